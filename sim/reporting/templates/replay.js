"use strict";
// The replay of one flight: everything is drawn anew for one instant, `now`; nothing else is remembered.
(() => {
  const section = document.getElementById("replay");
  const data = JSON.parse(document.getElementById("replay-data").textContent);
  const part = (name) => section.querySelector(`[data-part="${name}"]`);
  const flight = data.flight, first = flight.t[0], last = flight.t[flight.t.length - 1];
  const known = flight.x.length > 0; // or there are only plots and what trackers made of them
  const TRAIL = 90, FRESH = 40; // s: how long estimates and measurements stay in sight
  const FAINT = 0.35; // of the strength of other plots, for false ones
  const INK = "#1b1b1b", PALE = "#c4c4c4", ROUTE = "#777", PLOT = "#555";
  let now = data.opens, playing = false, lastFrame = null;

  // ---- looking things up -----------------------------------------------------------------------------------------
  function upTo(times, t) { // index of the last entry that is not after t, -1 before the first
    let low = 0, high = times.length;
    while (low < high) { const middle = (low + high) >> 1; if (times[middle] <= t) low = middle + 1; else high = middle; }
    return low - 1;
  }
  function at(name, t) { // a record of the flight, linear between its instants
    const values = flight[name], i = Math.max(0, upTo(flight.t, t));
    if (i + 1 >= values.length || values[i] == null || values[i + 1] == null) return values[i] ?? null;
    return values[i] + (values[i + 1] - values[i]) * (t - flight.t[i]) / (flight.t[i + 1] - flight.t[i]);
  }
  const phase = (t) => data.phases[Math.max(0, upTo(data.phases.map((p) => p.from), t))];
  const shown = data.trackers.map(() => true);
  const metres = (v) => v == null || !isFinite(v) ? "–" : Math.abs(v) >= 9999.5 ? "> 9999" : v.toFixed(Math.abs(v) < 99.95 ? 1 : 0).replace("-", "−");

  // ---- drawing ---------------------------------------------------------------------------------------------------
  function sheet(canvas) { // a clean canvas, sharp on every screen
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.lineJoin = pen.lineCap = "round";
    pen.font = "12px Helvetica, Arial, sans-serif";
    return { pen, width, height };
  }
  function line(pen, points, colour, width, dash = []) {
    pen.beginPath(); pen.strokeStyle = colour; pen.lineWidth = width; pen.setLineDash(dash);
    let open = false;
    for (const p of points) {
      if (p == null) { open = false; continue; }
      if (open) pen.lineTo(p[0], p[1]); else pen.moveTo(p[0], p[1]);
      open = true;
    }
    pen.stroke(); pen.setLineDash([]);
  }
  function dot(pen, p, radius, colour) { pen.beginPath(); pen.fillStyle = colour; pen.arc(p[0], p[1], radius, 0, 2 * Math.PI); pen.fill(); }
  function bounds(xs, ys) {
    const finite = (values) => values.filter((v) => v != null);
    const x = finite(xs), y = finite(ys);
    return [Math.min(...x), Math.max(...x), Math.min(...y), Math.max(...y)];
  }
  const extent = bounds(...[0, 1].map((axis) => [
    ...flight[axis ? "y" : "x"], ...(known ? data.route : []).map((p) => p[axis]), ...data.runway.map((p) => p[axis]),
    ...(known ? [] : data.plots).flatMap((plots) => plots[axis ? "y" : "x"])]));
  function latest(t) { // where the last plot was
    const seen = data.plots.map((plots) => [plots, upTo(plots.t, t)]).filter(([plots, i]) => i >= 0 && plots.x[i] != null);
    const [plots, i] = seen.sort((a, b) => b[0].t[b[1]] - a[0].t[a[1]])[0] ?? [null, 0];
    return plots ? [plots.x[i], plots.y[i]] : [(extent[0] + extent[1]) / 2, (extent[2] + extent[3]) / 2];
  }
  const heights = bounds([0], [...flight.height, ...flight.asked, 0, 30]);

  function round(length) { // the largest of 1, 2, 5 times a power of ten below a length
    const power = 10 ** Math.floor(Math.log10(length));
    return [5, 2, 1].find((n) => n * power <= length) * power;
  }

  function plan() {
    const { pen, width, height } = sheet(part("plan"));
    const span = Number(part("view").value), me = [at("x", now), at("y", now)];
    let scale, centre;
    if (span) { scale = width / span; centre = known ? me : latest(now); }
    else {
      scale = Math.min((width - 50) / (extent[1] - extent[0] || 1), (height - 50) / (extent[3] - extent[2] || 1));
      centre = [(extent[0] + extent[1]) / 2, (extent[2] + extent[3]) / 2];
    }
    const place = (x, y) => x == null ? null : [width / 2 + (x - centre[0]) * scale, height / 2 + (y - centre[1]) * scale];
    const path = (source, from, to) => source.x.slice(from, to).map((x, i) => place(x, source.y[from + i]));
    const gone = upTo(flight.t, now) + 1;
    line(pen, data.route.map((p) => place(...p)), ROUTE, 1, [6, 4]);
    line(pen, data.runway.map((p) => place(...p)), INK, Math.min(Math.max(45 * scale, 4), 30));
    line(pen, path(flight, gone - 1, flight.x.length), PALE, 1.5);
    line(pen, [...path(flight, 0, gone), place(...me)], INK, 1.5);
    for (const plots of data.plots) {
      const end = upTo(plots.t, now) + 1;
      for (let i = span ? upTo(plots.t, now - FRESH) + 1 : 0; i < end; i++) {
        const p = place(plots.x[i], plots.y[i]);
        if (!p) continue;
        pen.globalAlpha = (span ? 0.25 + 0.75 * (1 - (now - plots.t[i]) / FRESH) : 0.3) * (plots.false ? FAINT : 1);
        line(pen, [[p[0] - 3, p[1]], [p[0] + 3, p[1]]], PLOT, 1);
        line(pen, [[p[0], p[1] - 3], [p[0], p[1] + 3]], PLOT, 1);
      }
    }
    pen.globalAlpha = span ? 0.5 : 1; // close by, estimates are read through it
    if (known) aircraft(pen, place(...me), at("heading", now) * Math.PI / 180);
    pen.globalAlpha = 1;
    data.trackers.forEach((tracker, index) => {
      const i = upTo(tracker.t, now);
      if (!shown[index] || i < 0 || tracker.x[i] == null) return;
      const dash = tracker.dash;
      const from = upTo(tracker.t, now - TRAIL) + 1;
      line(pen, path(tracker, from, i + 1), tracker.colour, 1.3, dash);
      const p = place(tracker.x[i], tracker.y[i]);
      dot(pen, p, 3.2, tracker.colour);
      const long = tracker.long[i] * scale;
      if (long > 3 && long < 1e5) {
        pen.beginPath(); pen.strokeStyle = tracker.colour; pen.lineWidth = 1.6; pen.setLineDash(dash);
        pen.ellipse(p[0], p[1], long, Math.max(tracker.short[i] * scale, 0.5), tracker.direction[i], 0, 2 * Math.PI);
        pen.stroke(); pen.setLineDash([]);
      }
    });
    ruler(pen, height, scale, width);
    if (known) horizon(pen, width - 62, 58, at("bank", now));
  }
  function aircraft(pen, p, heading) { // seen from above, nose along its heading
    pen.save(); pen.translate(p[0], p[1]); pen.rotate(heading);
    pen.beginPath();
    for (const [x, y] of [[13, 0], [4, 2], [1, 13], [-2, 13], [-1, 2], [-8, 1.5], [-10, 5], [-12, 5], [-11, 0]]) pen.lineTo(x, y);
    for (const [x, y] of [[-12, -5], [-10, -5], [-8, -1.5], [-1, -2], [-2, -13], [1, -13], [4, -2]]) pen.lineTo(x, y);
    pen.closePath(); pen.fillStyle = INK; pen.fill();
    pen.strokeStyle = "#fff"; pen.lineWidth = 1; pen.stroke(); pen.restore();
  }
  function horizon(pen, x, y, bank) { // seen from behind: wings turned by the bank
    pen.save(); pen.translate(x, y);
    pen.fillStyle = "rgba(255,255,255,.88)"; pen.beginPath(); pen.arc(0, 0, 44, 0, 2 * Math.PI); pen.fill();
    pen.strokeStyle = PALE; pen.lineWidth = 1.5; pen.stroke();
    line(pen, [[-44, 0], [44, 0]], PALE, 1);
    pen.save(); pen.rotate((bank ?? 0) * Math.PI / 180);
    line(pen, [[-36, -2], [36, -2]], INK, 4); line(pen, [[0, -2], [0, -15]], INK, 3); line(pen, [[-9, -14], [9, -14]], INK, 2.5);
    pen.fillStyle = INK; pen.beginPath(); pen.arc(0, 0, 6, 0, 2 * Math.PI); pen.fill(); pen.restore();
    pen.fillStyle = INK; pen.textAlign = "center";
    pen.fillText(bank == null ? "bank –" : Math.abs(bank) < 0.05 ? "bank 0°" : `bank ${Math.abs(bank).toFixed(1)}° ${bank > 0 ? "right" : "left"}`, 0, 60);
    pen.restore();
  }
  function ruler(pen, height, scale, width) {
    const length = round(width / 5 / scale), pixels = length * scale, y = height - 14;
    line(pen, [[14, y - 4], [14, y], [14 + pixels, y], [14 + pixels, y - 4]], INK, 1.5);
    pen.fillStyle = INK; pen.textAlign = "left";
    pen.fillText(length >= 1000 ? `${length / 1000} km` : `${length} m`, 14, y - 8);
  }

  function profile() {
    const { pen, width, height } = sheet(part("profile"));
    const span = Number(part("view").value), left = 46, bottom = height - 22;
    const total = flight.flown[flight.flown.length - 1] || 1, here = at("flown", now);
    const from = span ? here - span / 2 : -0.02 * total, to = span ? here + span / 2 : 1.02 * total;
    let low = heights[2], high = heights[3];
    if (span) { // a window as high as is flown within it, 60 m at least
      const a = Math.max(0, upTo(flight.flown, from)), b = upTo(flight.flown, to) + 2;
      const inside = flight.height.slice(a, b).filter((v) => v != null);
      const middle = (Math.min(...inside) + Math.max(...inside)) / 2;
      const half = Math.max(Math.max(...inside) - middle, 30, span / 60);
      low = middle - half; high = middle + half;
    }
    const margin = 0.1 * (high - low); low -= margin; high += margin;
    const place = (d, h) => d == null || h == null ? null : [left + (d - from) / (to - from) * (width - left - 8), bottom - (h - low) / (high - low) * (bottom - 8)];
    const step = round((high - low) / 2.5);
    pen.fillStyle = "#555"; pen.textAlign = "right"; pen.textBaseline = "middle";
    for (let h = Math.ceil(low / step) * step; h <= high; h += step) {
      line(pen, [place(from, h), place(to, h)], "#e8e8e8", 1);
      pen.fillText(String(Math.round(h)).replace("-", "−"), left - 6, place(from, h)[1]);
    }
    pen.textBaseline = "alphabetic"; pen.textAlign = "left";
    pen.fillText("height, m, over the distance flown", left, height - 5);
    pen.save(); pen.beginPath(); pen.rect(left, 0, width - left, bottom); pen.clip();
    const along = (values, a, b) => values.slice(a, b).map((h, i) => place(flight.flown[a + i], h));
    const gone = upTo(flight.t, now) + 1;
    line(pen, along(flight.asked, 0, flight.t.length), PALE, 5);
    line(pen, along(flight.height, gone - 1, flight.t.length), "#999", 1.2);
    line(pen, along(flight.height, 0, gone), INK, 1.6);
    for (const plots of data.plots) {
      if (!plots.height.length) continue;
      const end = upTo(plots.t, now) + 1;
      for (let i = span ? upTo(plots.t, now - FRESH) + 1 : 0; i < end; i++) {
        const p = place(at("flown", plots.t[i]), plots.height[i]);
        if (p) { pen.globalAlpha = (span ? 0.7 : 0.3) * (plots.false ? FAINT : 1); dot(pen, p, 1.5, PLOT); }
      }
    }
    pen.globalAlpha = 1;
    data.trackers.forEach((tracker, index) => {
      const i = upTo(tracker.t, now);
      if (!shown[index] || i < 0 || !tracker.height.length) return;
      const begin = upTo(tracker.t, now - TRAIL) + 1;
      const points = tracker.height.slice(begin, i + 1).map((h, j) => place(at("flown", tracker.t[begin + j]), h));
      line(pen, points, tracker.colour, 1.4, tracker.dash);
      const d = at("flown", tracker.t[i]), h = tracker.height[i];
      const bar = [place(d, h - tracker.spread[i]), place(d, h + tracker.spread[i])];
      if (bar[0] && bar[1]) line(pen, bar, tracker.colour, 2.2);
    });
    const p = place(here, at("height", now));
    pen.restore();
    if (p) sideways(pen, p, at("pitch", now) * Math.PI / 180);
  }
  function sideways(pen, p, pitch) { // seen from the left: nose to the right
    pen.save(); pen.translate(p[0], p[1]); pen.rotate(-pitch);
    pen.beginPath();
    for (const [x, y] of [[15, 0], [11, -3], [-9, -2.5], [-13, -10], [-16, -10], [-15, 0], [-6, 2.5], [11, 2.5]]) pen.lineTo(x, y);
    pen.closePath(); pen.fillStyle = INK; pen.fill(); pen.strokeStyle = "#fff"; pen.lineWidth = 1; pen.stroke(); pen.restore();
  }

  // ---- what is said in words -------------------------------------------------------------------------------------
  function words() {
    const flown = phase(now), clock = part("clock");
    clock.textContent = `${now.toFixed(1)} s`;
    part("phase").textContent = flown.name;
    part("phase").style.borderColor = flown.colour;
    part("state").textContent = known ? `height ${metres(at("height", now))} m, true airspeed ${metres(at("speed", now))} m/s` : "";
    const slider = part("time");
    slider.value = now;
    slider.setAttribute("aria-valuetext", `${now.toFixed(1)} seconds, ${flown.name}`);
    data.trackers.forEach((tracker, index) => {
      const cells = rows[index].cells, i = upTo(tracker.t, now);
      let off = null, promised = null;
      if (i >= 0 && tracker.x.length && tracker.x[i] != null) {
        off = !known ? null : Math.hypot(tracker.x[i] - at("x", tracker.t[i]), tracker.y[i] - at("y", tracker.t[i]));
        promised = tracker.long[i];
      } else if (i >= 0 && tracker.height.length && tracker.height[i] != null) {
        off = !known ? null : Math.abs(tracker.height[i] - at("height", tracker.t[i]));
        promised = tracker.spread[i];
      }
      cells[1].textContent = metres(off);
      cells[2].textContent = metres(promised);
      cells[3].textContent = off == null ? "–" : off > 2 * promised ? "beyond 4 σ" : "";
    });
  }
  const rows = data.trackers.map((tracker, index) => { // a row with a switch for each tracker
    const row = part("trackers").insertRow(), box = document.createElement("input"), label = document.createElement("label");
    const key = document.createElement("span");
    box.type = "checkbox"; box.checked = true;
    box.addEventListener("change", () => { shown[index] = box.checked; draw(); });
    let end = 0;
    const parts = tracker.dash.map((length, i) => `${i % 2 ? "transparent" : tracker.colour} ${end}px ${(end += 1.7 * length)}px`);
    key.className = "key"; key.style.height = "3px";
    key.style.background = parts.length ? `repeating-linear-gradient(90deg, ${parts.join(", ")})` : tracker.colour;
    label.append(box, key, tracker.name);
    row.insertCell().append(label);
    for (let i = 0; i < 3; i++) row.insertCell().className = "n";
    return row;
  });
  if (!rows.length) part("table").hidden = true;
  if (!known) part("profile").remove(); // over the distance flown, which nobody knows

  // ---- moving ----------------------------------------------------------------------------------------------------
  function draw() {
    document.dispatchEvent(new CustomEvent("replayed", { detail: now })); // the figures show the same instant
    plan(); if (known) profile(); words();
  }
  function go(t) { now = Math.min(Math.max(t, first), last); draw(); }
  function play(on) {
    playing = on; lastFrame = null;
    part("play").textContent = on ? "Pause" : "Play";
    if (on) { if (now >= last) go(first); window.requestAnimationFrame(frame); }
  }
  function frame(stamp) {
    if (!playing) return;
    if (lastFrame != null) go(now + (stamp - lastFrame) / 1000 * Number(part("speed").value));
    lastFrame = stamp;
    if (now >= last) play(false); else window.requestAnimationFrame(frame);
  }
  part("play").addEventListener("click", () => play(!playing));
  part("start").addEventListener("click", () => go(first));
  part("end").addEventListener("click", () => go(last));
  part("view").addEventListener("change", draw);
  const slider = part("time");
  slider.min = first; slider.max = last; slider.step = 0.1;
  slider.addEventListener("input", () => go(Number(slider.value)));
  section.addEventListener("keydown", (event) => {
    const name = event.target.tagName, wheel = name === "SELECT", ticked = event.target.type === "checkbox";
    if (event.altKey || event.ctrlKey || event.metaKey || wheel) return;
    const stride = event.shiftKey ? 10 : 1;
    const moves = { ArrowRight: () => go(now + stride), ArrowLeft: () => go(now - stride), Home: () => go(first), End: () => go(last) };
    if (event.key === " " && name !== "BUTTON" && !ticked) moves[" "] = () => play(!playing);
    if (moves[event.key]) { event.preventDefault(); moves[event.key](); }
  });
  document.addEventListener("pointed", (event) => go(event.detail)); // at a figure
  window.addEventListener("resize", draw);
  section.hidden = false;
  draw();
})();
