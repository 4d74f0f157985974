"use strict";
// The figures and tables of a page: values under the pointer, zoom, one cursor on all axes of time, sorted columns.
// Everything is read off the drawings: a panel says which window of values it shows, a mark which name it has.
(() => {
  const TELLS = 6, NEAR = 60; // curves that are told at once; tenths of a point from a dot that is told
  const LEAST = 12; // pixels: a drag that is shorter is a click
  const tip = document.createElement("div");
  tip.className = "tip"; tip.hidden = true; tip.setAttribute("role", "status");
  document.body.append(tip);

  // ---- scales ----------------------------------------------------------------------------------------------------
  function axis(low, high, scale = "linear") { // values to lengths on a scale and back
    const [kind, to, decades] = scale.split(" "), linear = Number(to), half = Number(decades);
    const forward = { linear: (v) => v, log: Math.log10, symmetric: (v) => { const s = Math.abs(v) / linear;
      return Math.sign(v) * (s > 1 ? half + Math.log10(s) : half * s); } }[kind];
    const back = { linear: (u) => u, log: (u) => 10 ** u, symmetric: (u) => { const s = Math.abs(u);
      return Math.sign(u) * linear * (s > half ? 10 ** (s - half) : s / half); } }[kind];
    const begin = forward(Number(low)), span = forward(Number(high)) - begin;
    return { kind, low: Number(low), high: Number(high), value: (share) => back(begin + share * span), share: (v) => (forward(v) - begin) / span };
  }
  function steps(low, high, most) { // round numbers between two ends
    const least = Math.min(low, high), span = Math.abs(high - low), power = 10 ** Math.floor(Math.log10(span / most));
    const step = [1, 2, 2.5, 5, 10, 20].map((n) => n * power).find((n) => span / n <= most), found = [];
    for (let k = Math.ceil(least / step - 1e-9); k * step <= least + span * (1 + 1e-9); k++) found.push(k * step);
    return { found, places: Math.max(0, -Math.floor(Math.log10(step * 1.0001)) + (step / power === 2.5 ? 1 : 0)) };
  }
  const minus = (text) => text.replace("-", "−");
  function told(value) { // to four figures
    const size = Math.abs(value), places = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 1 ? 2 : 4;
    return minus(size < 1e-9 ? "0" : value.toFixed(places));
  }

  // ---- panels ----------------------------------------------------------------------------------------------------
  const panels = [...document.querySelectorAll("svg.drawing svg.panel")].map((element) => {
    const { width: wide, height: high } = element.viewBox.baseVal, data = element.dataset;
    const x = axis(data.x0, data.x1, data.xScale), y = axis(data.y0, data.y1, data.yScale), after = element.nextElementSibling;
    const even = x.kind === "linear" && y.kind === "linear" &&
      Math.abs(Math.abs((x.high - x.low) / wide / ((y.high - y.low) / high)) - 1) < 0.01; // a map
    return { element, wide, high, x, y, map: even, timed: "time" in data, fixed: "fixed" in data, whole: { left: 0, top: 0, wide, high },
      view: { left: 0, top: 0, wide, high }, drawing: element.closest("svg.drawing"), outside: after && after.tagName === "g" ? after : null };
  });
  const times = panels.filter((panel) => panel.timed);
  const curve = (panel) => panel.curves ??= [...panel.element.querySelectorAll("path[data-name]")]
    .filter((path) => (path.getAttribute("fill") ?? "none") === "none").map((path) => ({ path, name: path.dataset.name, runs: runs(path.getAttribute("d")) }));
  function runs(text) { // the points of a path in units, a run for each stretch without a break
    const found = [], words = text.match(/[a-zA-Z]|-?\d+/g) ?? [];
    let x = 0, y = 0, order = "", at = 0;
    const next = () => Number(words[at++]);
    while (at < words.length) {
      if (/[a-zA-Z]/.test(words[at])) order = words[at++];
      if (order === "M") { x = next(); y = next(); found.push([[x, y]]); order = "L"; continue; }
      if (order === "m") { x += next(); y += next(); found.push([[x, y]]); order = "l"; continue; }
      if (order === "l") { x += next(); y += next(); }
      else if (order === "h") x += next();
      else if (order === "v") y += next();
      else break; // rings and markers are no curves
      found[found.length - 1].push([x, y]);
    }
    return found;
  }
  function nearest(one, u, v) { // [how far up or down, height] of a curve at u units, by the branch nearest to v
    let best = null;
    const take = (height, away) => { if (best == null || away < best[0]) best = [away, height]; };
    for (const run of one.runs) {
      for (let i = 1; i < run.length; i++) {
        const [a, b] = [run[i - 1], run[i]], [low, high] = a[0] < b[0] ? [a[0], b[0]] : [b[0], a[0]];
        if (u < low || u > high) continue;
        const height = a[0] === b[0] ? (a[1] + b[1]) / 2 : a[1] + (b[1] - a[1]) * (u - a[0]) / (b[0] - a[0]);
        if (a[0] !== b[0] || a[1] !== b[1]) take(height, Math.abs(height - v));
        else if (Math.abs(a[0] - u) < NEAR) take(height, Math.abs(height - v) + NEAR);
      }
    }
    return best;
  }
  function place(panel, event) { // units of a pointer within a panel
    const box = panel.drawing.getBoundingClientRect(), { left, top, wide, high } = panel.view; // the panel's own holds what it hides
    const scale = box.width / panel.drawing.viewBox.baseVal.width, [x, y] = ["x", "y"].map((side) => panel.element[side].baseVal.value);
    return [left + ((event.clientX - box.left) / scale - x) / panel.wide * wide, top + ((event.clientY - box.top) / scale - y) / panel.high * high];
  }

  // ---- values under the pointer ----------------------------------------------------------------------------------
  function tell(panel, event) {
    const [u, v] = place(panel, event), x = panel.x.value(u / panel.wide), lines = [];
    const name = panel.timed ? "time, s" : panel.fixed ? "" : "x";
    if (!panel.fixed) lines.push(["", `${name} ${panel.timed ? x.toFixed(1) : told(x)}${panel.map ? `, y ${told(panel.y.value(1 - v / panel.high))}` : ""}`]);
    curve(panel).map((one) => [one, nearest(one, u, v)]).filter(([, found]) => found).sort((a, b) => a[1][0] - b[1][0]).slice(0, TELLS)
      .forEach(([one, [, height]]) => lines.push([getComputedStyle(one.path).stroke, `${one.name} ${panel.map ? "" : told(panel.y.value(1 - height / panel.high))}`]));
    tip.replaceChildren(...lines.map(([colour, text]) => {
      const line = document.createElement("div"), key = document.createElement("i");
      if (colour) { key.style.background = colour; line.append(key); }
      line.append(text);
      return line;
    }));
    tip.hidden = !lines.length;
    const right = event.clientX > window.innerWidth / 2;
    tip.style.left = right ? "auto" : `${event.clientX + 14}px`;
    tip.style.right = right ? `${window.innerWidth - event.clientX + 14}px` : "auto";
    tip.style.top = `${Math.min(event.clientY + 14, window.innerHeight - tip.offsetHeight - 8)}px`;
  }

  // ---- one cursor on all axes of time ----------------------------------------------------------------------------
  let shown = null; // s, of the replay
  function path(panel, name) {
    const found = document.createElementNS(panel.element.namespaceURI, "path");
    found.setAttribute("class", name);
    panel.element.append(found);
    return found;
  }
  function point(time) {
    for (const panel of times) {
      panel.cursor ??= path(panel, "cursor");
      if (time == null) panel.cursor.removeAttribute("d");
      else panel.cursor.setAttribute("d", `M${Math.round(panel.wide * panel.x.share(time))} 0v${panel.high}`);
    }
  }
  document.addEventListener("replayed", (event) => { shown = event.detail; point(shown); });

  // ---- zoom ------------------------------------------------------------------------------------------------------
  function look(panel, view) { // show a part of a panel; strokes and letters keep their size
    const { element, wide, high, whole } = panel, zoomed = view.wide < whole.wide || view.high < whole.high;
    const [kx, ky] = [view.wide / wide, view.high / high];
    panel.view = view;
    panel.drawing.classList.toggle("zoomed", zoomed);
    element.setAttribute("viewBox", `${view.left} ${view.top} ${view.wide} ${view.high}`);
    const scale = panel.drawing.getBoundingClientRect().width / panel.drawing.viewBox.baseVal.width;
    for (const one of element.querySelectorAll(":scope > path[stroke-width], :scope > .cursor")) {
      const width = Number(one.getAttribute("stroke-width") ?? 8) * scale, dashes = one.getAttribute("stroke-dasharray");
      one.style.vectorEffect = zoomed ? "non-scaling-stroke" : "";
      one.style.strokeWidth = zoomed ? `${width}px` : "";
      if (dashes) one.style.strokeDasharray = zoomed ? dashes.split(" ").map((dash) => `${dash * scale}px`).join(" ") : "";
    }
    for (const one of element.querySelectorAll(":scope > text")) {
      const [x, y] = [Number(one.getAttribute("x")), Number(one.getAttribute("y"))];
      one.dataset.turn ??= one.getAttribute("transform") ?? "";
      one.setAttribute("transform", `translate(${x * (1 - kx)} ${y * (1 - ky)}) scale(${kx} ${ky}) ${one.dataset.turn}`);
    }
    const legend = element.querySelector(":scope > .legend");
    if (legend) legend.setAttribute("transform", `translate(${view.left} ${view.top}) scale(${kx} ${ky})`);
    number(panel, zoomed);
  }
  function number(panel, zoomed) { // the axes' numbers and the grid for what is shown
    const { element, outside, view, wide, high } = panel, grid = element.querySelector(":scope > .grid");
    const part = (low, size, whole, own) => [low, low + size].map((at) => own.value(own === panel.y ? 1 - at / whole : at / whole));
    const sides = { x: [panel.x, part(view.left, view.wide, wide, panel.x), "x-numbers"], y: [panel.y, part(view.top, view.high, high, panel.y), "y-numbers"] };
    let lines = "";
    for (const [side, [own, ends, name]] of Object.entries(sides)) {
      const group = outside?.querySelector(`:scope > .${name}`) ?? null, moved = side === "x" ? view.wide < wide : view.high < high;
      if (group) panel[name] ??= [...group.childNodes].map((one) => one.cloneNode(true));
      const { found, places } = steps(...ends, side === "x" ? 8 : 6);
      const at = (value) => side === "x" ? wide * own.share(value) : high * (1 - own.share(value));
      if (moved) lines += found.map((value) => side === "x" ? `M${Math.round(at(value))} 0v${high}` : `M0 ${Math.round(at(value))}h${wide}`).join("");
      else if (grid) lines += ((panel.grid ??= grid.getAttribute("d")).match(side === "x" ? /M-?\d+ 0v\d+/g : /M0 -?\d+h\d+/g) ?? []).join("");
      if (!group) continue;
      if (!moved) { group.replaceChildren(...panel[name].map((one) => one.cloneNode(true))); continue; }
      const first = panel[name][0];
      group.replaceChildren(...found.map((value) => {
        const one = first.cloneNode(false), from = side === "x" ? (at(value) - view.left) / view.wide * wide : (at(value) - view.top) / view.high * high;
        one.setAttribute(side, Math.round(side === "x" ? from : from + 0.036 * 75 * 10));
        one.textContent = minus(value.toFixed(places));
        return one;
      }));
    }
    if (grid) { panel.grid ??= grid.getAttribute("d"); grid.setAttribute("d", zoomed ? lines : panel.grid); }
  }
  function zoom(panel, left, right, middle = panel.high / 2) { // from one place of x to another, in units
    const wide = Math.max(right - left, panel.wide / 500);
    if (panel.map) {
      const high = panel.high * wide / panel.wide, top = Math.min(Math.max(middle - high / 2, 0), panel.high - high);
      look(panel, { left, top, wide, high });
      return;
    }
    const ends = [left, left + wide].map((at) => panel.x.value(at / panel.wide));
    for (const one of panel.timed ? times : panels.filter((other) => other.drawing === panel.drawing && !other.fixed && !other.map &&
      other.x.low === panel.x.low && other.x.high === panel.x.high)) {
      const [from, to] = ends.map((value) => one.wide * one.x.share(value));
      look(one, { left: from, top: 0, wide: to - from, high: one.high });
    }
  }
  const alike = (panel) => panel.timed ? times : panels.filter((other) => other.drawing === panel.drawing);
  const reset = (some) => some.forEach((panel) => { if (panel.view !== panel.whole) look(panel, panel.whole); });
  for (const panel of panels) {
    let begun = null, mark = null;
    const { element } = panel;
    element.addEventListener("pointermove", (event) => {
      tell(panel, event);
      const [u] = place(panel, event);
      if (panel.timed) point(panel.x.value(u / panel.wide));
      if (begun && mark) mark.setAttribute("d", `M${Math.round(begun.u)} 0H${Math.round(u)}V${panel.high}H${Math.round(begun.u)}z`);
    });
    element.addEventListener("pointerleave", () => { tip.hidden = true; point(shown); });
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || event.pointerType === "touch") return;
      const [u, v] = place(panel, event);
      begun = { u, v, x: event.clientX };
      if (!panel.fixed) mark = path(panel, "chosen");
      element.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    element.addEventListener("pointerup", (event) => {
      const from = begun, [u, v] = place(panel, event);
      mark?.remove(); begun = mark = null;
      if (!from) return;
      if (Math.abs(event.clientX - from.x) >= LEAST) { if (!panel.fixed) zoom(panel, Math.min(from.u, u), Math.max(from.u, u), (from.v + v) / 2); }
      else if (panel.timed) document.dispatchEvent(new CustomEvent("pointed", { detail: panel.x.value(u / panel.wide) }));
      tell(panel, event); // what is there now
    });
    element.addEventListener("pointercancel", () => { mark?.remove(); begun = mark = null; });
    element.addEventListener("dblclick", (event) => { event.preventDefault(); reset(alike(panel)); tell(panel, event); });
    element.addEventListener("wheel", (event) => { // with Ctrl, as two fingers spread on a pad: a page is to scroll over its figures
      if (!event.ctrlKey || panel.fixed) return;
      event.preventDefault();
      const [u, v] = place(panel, event), { left, wide } = panel.view, part = Math.min(wide * 1.2 ** Math.sign(event.deltaY), panel.wide);
      if (part >= panel.wide) { reset(alike(panel)); return; }
      const begin = Math.min(Math.max(u - (u - left) * part / wide, 0), panel.wide - part);
      zoom(panel, begin, begin + part, v);
      tell(panel, event);
    }, { passive: false });
  }

  // ---- tables ----------------------------------------------------------------------------------------------------
  const size = (text) => { const found = text.replaceAll("−", "-").match(/-?\d+(\.\d+)?(e[+-]?\d+)?/); return found ? Number(found[0]) : null; };
  for (const table of document.querySelectorAll("table.sorted")) {
    const [head, ...rows] = table.rows;
    [...head.cells].forEach((cell, column) => {
      const numeric = rows.some((row) => size(row.cells[column].textContent) != null) && (cell.classList.contains("n") || !rows.some((row) => /[a-z]{3}/i.test(row.cells[column].textContent)));
      const sort = () => {
        const down = cell.getAttribute("aria-sort") === "ascending" ? -1 : 1;
        [...head.cells].forEach((other) => other.removeAttribute("aria-sort"));
        cell.setAttribute("aria-sort", down === 1 ? "ascending" : "descending");
        const key = (row) => numeric ? size(row.cells[column].textContent) : row.cells[column].textContent.trim();
        const before = (a, b) => a == null || b == null ? (a == null) - (b == null) : down * (numeric ? a - b : a.localeCompare(b)); // the unknown last
        [...rows].sort((a, b) => before(key(a), key(b))).forEach((row) => head.parentNode.append(row));
      };
      cell.tabIndex = 0;
      cell.addEventListener("click", sort);
      cell.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); sort(); } });
    });
  }

  // ---- paper -----------------------------------------------------------------------------------------------------
  let folded = [];
  window.addEventListener("beforeprint", () => {
    reset(panels); point(null); tip.hidden = true;
    folded = [...document.querySelectorAll("details:not([open])")];
    folded.forEach((one) => { one.open = true; });
  });
  window.addEventListener("afterprint", () => { folded.forEach((one) => { one.open = false; }); point(shown); });
})();
