"""What an editor is given to help with a scenario file: ``json_schema`` makes the JSON Schema over all kinds."""
