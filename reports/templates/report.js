"use strict";
/* Moves every figure of the last cycle with one slider. The figures are drawn already: this changes lines and marks, never axes
   (but for the slip of chosen points). Without it the page is whole, and shows one instant. */
(() => {
  const SVG = "http://www.w3.org/2000/svg", NOTHING = -32768, SECONDS_A_CYCLE = 8, MOST_PLACES = 6;
  const find = (selector, root = document) => root.querySelector(selector);
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const data = JSON.parse(find("#cycle-data").textContent);
  if (!data.instants) return;
  const n = data.points, count = data.instants, { series, x } = data;

  // ---------------------------------------------------------------- numbers
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const fields = {};
  for (const [key, { step, data: text }] of Object.entries(data.fields)) {
    const whole = new DataView(bytes(text).buffer);
    fields[key] = Float64Array.from({ length: count * n }, (_, k) => {
      const value = whole.getInt16(2 * k, true);
      return value === NOTHING ? NaN : value * step;
    });
  }
  const states = bytes(data.states), STATE_WORDS = ["open", "stick", "forward slip", "reverse slip"];
  const stateOf = (engine, k, i) => (engine ? states[k * n + i] >> 2 : states[k * n + i] & 3);
  /* "p0": p of the reference; "p1": of the result; "dp": their difference in per cent. */
  const value = (name, k, i) => {
    const at = k * n + i;
    if (name[0] === "d") return 100 * fields[name][at];
    return fields[name[0]][at] + (name[1] === "1" ? fields[`d${name[0]}`][at] : 0);
  };
  const words = (v) => {
    if (!Number.isFinite(v)) return "none";
    const text = v !== 0 && (Math.abs(v) < 1e-3 || Math.abs(v) >= 1e5) ? v.toExponential(3) : String(+v.toPrecision(4));
    return text.replaceAll("-", "−");
  };
  const tickWords = (v) => (v !== 0 && Math.abs(v) < 1e-3 ? v.toExponential() : String(v)).replaceAll("-", "−");
  const nearest = (list, wanted) => list.reduce((best, v, k) => (Math.abs(v - wanted) < Math.abs(list[best] - wanted) ? k : best), 0);

  // ---------------------------------------------------------------- places in a panel
  const scale = (text) => {
    const [low, high, start, end, log] = text.split(" ").map(Number);
    const f = log ? Math.log10 : (v) => v, g = log ? (v) => 10 ** v : (v) => v;
    return {
      low, high, start, end,
      place: (v) => start + ((f(v) - f(low)) / (f(high) - f(low))) * (end - start),
      number: (p) => g(f(low) + ((p - start) / (end - start)) * (f(high) - f(low))),
    };
  };
  const panels = new Map(all("svg.panel").map((svg) => [svg, { x: scale(svg.dataset.x), y: scale(svg.dataset.y) }]));
  const make = (name, attributes, parent) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, v] of Object.entries(attributes)) made.setAttribute(key, v);
    return parent.appendChild(made);
  };
  const line = (axes, across, up) => {
    let text = "", pen = "M";
    for (let k = 0; k < across.length; k++) {
      if (Number.isFinite(up[k]) && Number.isFinite(across[k])) {
        text += pen + axes.x.place(across[k]).toFixed(2) + " " + axes.y.place(up[k]).toFixed(2);
        pen = "L";
      } else pen = "M";
    }
    return text || "M0 0";
  };

  // ---------------------------------------------------------------- what the slider moves
  const curves = all("path[data-field]").map((path) => ({ path, axes: panels.get(path.closest("svg")), name: path.dataset.field }));
  const strips = all("g.strip").map((group) => ({ group, axes: panels.get(group.closest("svg")), engine: +group.dataset.strip }));
  const rings = all("circle.follow").map((ring) => ({ ring, axes: panels.get(ring.closest("svg")), at: ring.dataset }));
  const cursors = all('svg[data-time="x"], svg[data-time="y"]').map((svg) => {
    const axes = panels.get(svg), upright = svg.dataset.time === "x";
    const [a, b] = upright ? [axes.y.start, axes.y.end] : [axes.x.start, axes.x.end];
    const ends = upright ? { y1: a, y2: b } : { x1: a, x2: b };
    return { mark: make("line", { class: "cursor", ...ends }, svg), axis: upright ? axes.x : axes.y, names: upright ? ["x1", "x2"] : ["y1", "y2"] };
  });
  const slider = find("#instant"), readout = find("#readout"), play = find("#play"), chips = find("#events");
  let now = 0;

  const drawStrip = ({ group, axes, engine }) => {
    group.replaceChildren();
    let start = axes.x.start;
    for (let i = 0; i < n; i++) {
      const state = stateOf(engine, now, i);
      if (i + 1 < n && stateOf(engine, now, i + 1) === state) continue;
      const middle = i + 1 < n ? axes.x.place((x[i] + x[i + 1]) / 2) : axes.x.end;
      const end = Math.min(Math.max(middle, axes.x.start), axes.x.end);
      if (end > start) make("rect", { x: start, y: group.dataset.top, width: end - start, height: 16, class: `state-${state}` }, group);
      start = end;
    }
  };
  const show = (k) => {
    now = Math.min(Math.max(k, 0), count - 1);
    const indices = x.map((_, i) => i);
    for (const { path, axes, name } of curves) path.setAttribute("d", line(axes, x, indices.map((i) => value(name, now, i))));
    strips.forEach(drawStrip);
    for (const { ring, axes, at } of rings) {
      const [across, up] = [series[at.seriesX][now], series[at.seriesY][now]];
      const there = across !== null && up !== null;
      ring.style.display = there ? "" : "none";
      if (there) ring.setAttribute("cx", axes.x.place(across)), ring.setAttribute("cy", axes.y.place(up));
    }
    for (const { mark, axis, names } of cursors) names.forEach((name) => mark.setAttribute(name, axis.place(series.t[now])));
    const event = data.events.find(([row]) => row === now);
    const text = `${data.time_words} ${words(series.t[now])} · P ${words(series.P[now])} · Q ${words(series.Q[now])} ${data.load_unit}`;
    slider.value = now;
    slider.setAttribute("aria-valuetext", event ? `${text}, ${event[1]}` : text);
    readout.textContent = text;
    all("button", chips).forEach((chip, k) => chip.setAttribute("aria-pressed", String(data.events[k][0] === now)));
    all("[data-event]").forEach((mark) => mark.classList.toggle("here", data.rows[now] === +mark.dataset.event));
  };

  // ---------------------------------------------------------------- play, keys, chosen instants
  let playing = 0, phase = 0, last = 0;
  const span = series.t[count - 1] - series.t[0];
  const frame = (at) => {
    phase = (phase + (at - (last || at)) / 1000 / SECONDS_A_CYCLE) % 1;
    last = at;
    show(nearest(series.t, series.t[0] + phase * span));
    playing = requestAnimationFrame(frame);
  };
  const setPlaying = (on) => {
    cancelAnimationFrame(playing);
    playing = last = 0;
    phase = now === count - 1 ? 0 : (series.t[now] - series.t[0]) / span;
    if (on) playing = requestAnimationFrame(frame);
    play.setAttribute("aria-pressed", String(on));
    play.setAttribute("aria-label", on ? "Stop" : "Play the cycle");
  };
  const go = (k) => { setPlaying(false); show(k); };
  slider.max = count - 1;
  slider.addEventListener("input", () => go(+slider.value));
  play.addEventListener("click", () => setPlaying(!playing));
  data.events.forEach(([row, label], k) => {
    const chip = document.createElement("button");
    chip.type = "button";
    chip.textContent = `${k + 1} ${label}`;
    chip.addEventListener("click", () => go(row));
    chips.append(chip);
  });
  const typed = (target) => target.matches("input:not(#instant), textarea, select");
  document.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey || typed(event.target)) return;
    const inside = event.target.closest("#through") !== null, free = event.target === document.body;
    const steps = { ArrowLeft: now - 1, ArrowRight: now + 1, ArrowDown: now - 1, ArrowUp: now + 1, Home: 0, End: count - 1, PageDown: now - 10, PageUp: now + 10 };
    const onSlider = event.target === slider;
    if (event.key === " " && (onSlider || (inside && !event.target.matches("button, a, summary")))) setPlaying(!playing);
    else if (onSlider && event.key in steps) go(steps[event.key]);
    else if ((inside || free) && (event.key === "ArrowLeft" || event.key === "ArrowRight") && !event.target.matches(".wide")) go(steps[event.key]);
    else return;
    event.preventDefault();
  });
  all(".cell[data-event]").forEach((cell) => cell.addEventListener("click", () => go(nearest(data.rows, +cell.dataset.event))));

  // ---------------------------------------------------------------- slip of chosen points
  const slipPanel = find("#panel-slip"), form = find("#choose");
  let chosen = [...data.slip_points];
  const ticks = (low, high) => {
    const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 2.5, 5, 10].map((s) => s * power).find((s) => s >= 0.999 * rough);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) found.push(k * step);
    return found;
  };
  const setUpright = (svg, low, high) => {
    const axes = panels.get(svg), old = axes.y;
    const fresh = scale(`${low} ${high} ${old.start} ${old.end} 0`);
    panels.set(svg, { x: axes.x, y: fresh });
    all(".upright", svg).forEach((mark) => mark.remove());
    const place = find(".marks", svg);
    for (const number of ticks(low, high)) {
      const y = fresh.place(number);
      svg.insertBefore(make("line", { x1: axes.x.start, x2: axes.x.end, y1: y, y2: y, class: "grid upright" }, svg), place);
      make("text", { x: axes.x.start - 6, y: y + 4, class: "tick upright", "text-anchor": "end" }, svg).textContent = tickWords(+number.toPrecision(6));
    }
  };
  const drawSlip = () => {
    const slips = chosen.map((i) => [0, 1].map((engine) => series.t.map((_, k) => value(`s${engine}`, k, i) - value(`s${engine}`, 0, i))));
    const everything = slips.flat(2).filter(Number.isFinite).concat(0);
    const [low, high] = [Math.min(...everything), Math.max(...everything)], room = 0.06 * (high - low || 1);
    setUpright(slipPanel, low - room, high + room);
    const axes = panels.get(slipPanel), marks = find(".marks", slipPanel);
    all(".curve", marks).forEach((mark) => mark.remove());
    for (const engine of [0, 1]) slips.forEach((pair, k) => make("path", {
      d: line(axes, series.t, pair[engine]), class: `curve ${engine ? "thin" : "wide"} point-${k}`,
      "data-label": `x = ${words(x[chosen[k]])} a_ref, ${data.engines[engine]}`,
    }, marks));
    const legend = find("#slip_history .legend");
    legend.replaceChildren(...chosen.map((i, k) => {
      const item = document.createElement("li");
      make("path", { d: "M1 6H25", class: `curve thin point-${k}` }, item.appendChild(document.createElementNS(SVG, "svg"))).parentNode.setAttribute("viewBox", "0 0 26 12");
      item.append(`x = ${words(x[i])} a_ref`);
      return item;
    }));
    all(".pick-line").forEach((mark) => mark.remove());
    for (const svg of all("svg.pick")) chosen.forEach((i, k) => {
      const at = panels.get(svg).x.place(x[i]), { start, end } = panels.get(svg).y;
      make("line", { x1: at, x2: at, y1: start, y2: end, class: `pick-line point-${k}` }, svg);
    });
  };
  const choose = (place) => {
    const i = nearest(x, place);
    chosen = chosen.includes(i) ? chosen.filter((other) => other !== i) : [...chosen, i].slice(-MOST_PLACES);
    if (!chosen.length) chosen = [i];
    drawSlip();
  };
  const pointed = (svg, event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  if (slipPanel && form) {
    all("svg.pick").forEach((svg) => svg.addEventListener("click", (event) => {
      const { x: axis } = panels.get(svg), { x: at } = pointed(svg, event);
      if (at >= axis.start && at <= axis.end) choose(axis.number(at));
    }));
    form.addEventListener("submit", (event) => { event.preventDefault(); const at = find("#place").valueAsNumber; if (Number.isFinite(at)) choose(at); });
    find("#clear").addEventListener("click", () => { chosen = [...data.slip_points]; drawSlip(); });
    form.hidden = false;
    drawSlip();
  }

  // ---------------------------------------------------------------- numbers under the pointer
  const hint = document.body.appendChild(document.createElement("div"));
  hint.id = "hint";
  hint.hidden = true;
  hint.setAttribute("role", "status");
  const parsed = new WeakMap();
  const pointsOf = (path) => {
    const text = path.getAttribute("d"), kept = parsed.get(path);
    if (kept && kept.text === text) return kept.points;
    const points = text.slice(1).split(/[ML]/).map((pair) => pair.split(" ").map(Number));
    parsed.set(path, { text, points });
    return points;
  };
  const under = (svg, at) => {
    const axes = panels.get(svg), rows = [], seen = new Set();
    for (const path of all("path.curve[data-label]", svg)) {
      const points = pointsOf(path), rising = points.every((p, k) => !k || p[0] >= points[k - 1][0]);
      const far = (p) => (rising && points.length > 2 ? Math.abs(p[0] - at.x) : Math.hypot(p[0] - at.x, p[1] - at.y));
      const best = points.reduce((a, b) => (far(b) < far(a) ? b : a));
      if (far(best) > 14) continue;
      const up = axes.y.number(best[1]), label = path.dataset.label;
      const row = rising ? `${label}: ${words(up)}` : `${label}: (${words(axes.x.number(best[0]))}, ${words(up)})`;
      if (!seen.has(row)) seen.add(row), rows.push(row);
    }
    return rows;
  };
  const stateRows = (k, i) => data.engines.map((name, engine) => `${name}: ${STATE_WORDS[stateOf(engine, k, i)]}`);
  const hintRows = (svg, at, target) => {
    if (target.dataset.label && target.tagName === "rect") return [target.dataset.label];
    const axes = panels.get(svg), across = axes.x.number(at.x), up = axes.y.number(at.y);
    if (svg.id === "panel-zones") return [`x / a_ref: ${words(across)}`, ...stateRows(now, nearest(x, across))];
    if (find("image", svg)) return [`x / a_ref: ${words(across)}`, `${data.time_words}: ${words(up)}`, ...stateRows(nearest(series.t, up), nearest(x, across))];
    const rows = under(svg, at);
    return rows.length ? [`${svg.dataset.xWords || "x / a_ref"}: ${words(across)}`, ...rows] : [];
  };
  for (const [svg, { x: across }] of panels) {
    if (!across) continue;
    svg.addEventListener("pointermove", (event) => {
      const at = pointed(svg, event), axes = panels.get(svg);
      const outside = at.x < axes.x.start || at.x > axes.x.end || at.y < Math.min(axes.y.end, axes.y.start) || at.y > Math.max(axes.y.start, axes.y.end);
      const rows = outside ? [] : hintRows(svg, at, event.target);
      hint.hidden = !rows.length;
      hint.replaceChildren(...rows.map((row) => { const entry = document.createElement("div"); entry.textContent = row; return entry; }));
      const room = hint.getBoundingClientRect();
      hint.style.left = `${Math.max(4, Math.min(event.clientX + 14, innerWidth - room.width - 6))}px`;
      hint.style.top = `${event.clientY + 18 + room.height > innerHeight ? event.clientY - room.height - 10 : event.clientY + 18}px`;
    });
    svg.addEventListener("pointerleave", () => { hint.hidden = true; });
  }
  addEventListener("scroll", () => { hint.hidden = true; }, { passive: true });

  // ---------------------------------------------------------------- tables that the page carries
  all("a[data-csv]").filter((link) => link.dataset.csv in data.tables).forEach((link) => link.addEventListener("click", async (event) => {
    if (typeof DecompressionStream === "undefined") return;
    event.preventDefault();
    const stream = new Blob([bytes(data.tables[link.dataset.csv])]).stream().pipeThrough(new DecompressionStream("deflate"));
    const address = URL.createObjectURL(new Blob([await new Response(stream).text()], { type: "text/csv" }));
    const anchor = document.createElement("a");
    anchor.href = address;
    anchor.download = `${link.dataset.csv}.csv`;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  }));

  find("#controls").hidden = false;
  document.documentElement.classList.add("scripted-page");
  show(data.start);
})();
