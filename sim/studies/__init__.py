"""Many flights: what a study varies, its jobs and folder, its figures and its page."""
