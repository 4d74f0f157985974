// A browser starts no worker for a page that is opened as a file, and the search runs in one. There it runs in a frame.
if (location.protocol === "file:") {
  window.Worker = function (url) {
    const frame = document.createElement("iframe");
    const waiting = [];
    let ready = false;
    frame.hidden = true;
    document.documentElement.append(frame);
    const inside = frame.contentWindow;
    const give = (data) => inside.onmessage({ data });
    inside.postMessage = (data) => setTimeout(() => this.onmessage && this.onmessage({ data }));
    this.postMessage = (data) => (ready ? setTimeout(give, 0, data) : waiting.push(data));
    this.terminate = () => frame.remove();
    const script = frame.contentDocument.createElement("script");
    script.src = new URL(url, document.baseURI);
    script.onload = () => {
      ready = true;
      waiting.forEach(give);
    };
    script.onerror = () => this.onerror && this.onerror(new Event("error"));
    frame.contentDocument.documentElement.append(script);
  };
}
