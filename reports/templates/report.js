"use strict";
/* Figures are drawn already; this reads them, hides, zooms and saves them, and moves those of a cycle with one slider. Without it a
   page is whole and shows one instant. A panel says in data-x and data-y where its axes lie: low, high, start, end, logarithmic. */
(() => {
  const SVG = "http://www.w3.org/2000/svg", NOTHING = -32768, SECONDS_A_CYCLE = 8, MOST_PLACES = 6, MOST_ZOOM = 100, NARROW = 640;
  const find = (selector, root = document) => root.querySelector(selector);
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const set = (element, attributes) => { for (const [key, v] of Object.entries(attributes)) element.setAttribute(key, v); return element; };
  const make = (name, attributes, parent) => parent.appendChild(set(document.createElementNS(SVG, name), attributes));
  const minus = (text) => text.replaceAll("-", "−");
  const words = (v, digits = 4) => {
    if (!Number.isFinite(v)) return "none";
    return minus(v !== 0 && (Math.abs(v) < 1e-3 || Math.abs(v) >= 1e5) ? v.toExponential(digits - 1) : String(+v.toPrecision(digits)));
  };
  const tickWords = (v) => minus(v !== 0 && Math.abs(v) < 1e-3 ? v.toExponential() : String(v)).replace("+", "");
  const nearest = (list, wanted) => list.reduce((best, v, k) => (Math.abs(v - wanted) < Math.abs(list[best] - wanted) ? k : best), 0);
  /* Words with subscripts: a_ref, but no names of files: r_fine.csv. Inside a drawing they are moved down and back. */
  const typeset = (node, text) => {
    const parts = text.split(/(?<![\p{L}\p{N}])(\p{L})_([A-Za-z0-9]+)(?![A-Za-z0-9_]|\.[A-Za-z0-9])/u), drawn = node.namespaceURI === SVG;
    node.replaceChildren();
    let low = false;
    for (let k = 0; k < parts.length; k += 3) {
      const plain = parts[k] + (parts[k + 1] ?? "");
      if (drawn && low) make("tspan", { dy: -3.5 }, node).textContent = plain; else node.append(plain);
      if (low = k + 2 < parts.length) {
        const part = drawn ? make("tspan", { dy: 3.5, class: "sub" }, node) : node.appendChild(document.createElement("sub"));
        part.textContent = parts[k + 2];
      }
    }
    return node;
  };

  // ---------------------------------------------------------------- panels: where their axes lie, now and as drawn
  const scale = (low, high, start, end, log) => {
    const f = log ? Math.log10 : (v) => v, g = log ? (v) => 10 ** v : (v) => v, span = f(high) - f(low);
    return { low, high, start, end, log, place: (v) => start + ((f(v) - f(low)) / span) * (end - start), number: (p) => g(f(low) + ((p - start) / (end - start)) * span) };
  };
  const read = (text) => scale(...text.split(" ").map(Number));
  const panels = new Map(all("svg.panel[data-x]").map((svg) => {
    const x = read(svg.dataset.x), y = read(svg.dataset.y), box = svg.viewBox.baseVal;
    return [svg, { svg, x, y, base: { x, y }, width: box.width, height: box.height, drawn: box.width, marks: find(".marks", svg), area: find(":scope > .area", svg) }];
  }));
  const bases = new WeakMap();  // element -> its attributes in the axes as drawn
  const NAMES = { path: ["d"], line: ["x1", "x2", "y1", "y2"], rect: ["x", "y", "width", "height"], image: ["x", "y", "width", "height"], circle: ["cx", "cy"], text: ["x", "y"], g: ["transform"] };
  const is_moved = ({ x, y, base }) => x !== base.x || y !== base.y;
  const affine = (now, base) => {
    const from = base.place(now.low), factor = (now.end - now.start) / (base.place(now.high) - from);
    return [factor, now.start - factor * from];
  };
  const fit = (panel, element) => {
    const base = bases.get(element), [a, b] = affine(panel.x, panel.base.x), [c, d] = affine(panel.y, panel.base.y);
    const X = (v) => +(a * v + b).toFixed(2), Y = (v) => +(c * v + d).toFixed(2);
    if ("d" in base) element.setAttribute("d", base.d.replace(/([ML])([-\d.e]+) ([-\d.e]+)/g, (_, pen, x, y) => pen + X(x) + " " + Y(y)));
    else if ("transform" in base) element.setAttribute("transform", `matrix(${a} 0 0 ${c} ${b} ${d}) ${base.transform}`);
    else for (const [name, v] of Object.entries(base)) {
      element.setAttribute(name, name === "width" ? Math.abs(a * v) : name === "height" ? Math.abs(c * v) : /y/.test(name) ? Y(v) : X(v));
    }
  };
  /* Gives a mark its attributes in the axes as drawn, wherever these are now. */
  const put = (panel, element, attributes) => {
    set(element, attributes);
    const names = NAMES[element.tagName].filter((name) => element.hasAttribute(name));
    bases.set(element, Object.fromEntries(names.map((name) => [name, element.getAttribute(name)])));
    if (is_moved(panel)) fit(panel, element);
    return element;
  };
  const add = (panel, name, attributes) => put(panel, make(name, {}, panel.marks), attributes);
  const ticks = (low, high, count, log) => {
    const found = [];
    if (log) {
      const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9), fine = last - first < 2;
      const every = fine ? 1 : Math.ceil((last - first + 1) / (count + 1));
      for (let p = fine ? first - 1 : first; p <= last; p += every) for (const step of fine ? [1, 2, 5] : [1]) found.push(+(step * 10 ** p).toPrecision(12));
      const inside = found.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
      if (inside.length > 1) return inside;
      found.length = 0;
    }
    const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 2.5, 5, 10].map((s) => s * power).find((s) => s >= 0.999 * rough);
    for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) found.push(+(k * step).toPrecision(6) + 0);
    return found;
  };
  const drawAxes = (panel) => {
    const { svg, x, y, width, height } = panel, [across, up] = (svg.dataset.counts ?? "5 5").split(" ").map(Number);
    all(":scope > .grid, :scope > .tick", svg).forEach((mark) => mark.remove());
    const before = panel.marks.parentNode, custom = (svg.dataset.xTicks ?? "").split(" ").filter(Boolean).map((pair) => pair.split("="));
    const line = (attributes, css) => svg.insertBefore(make("line", { ...attributes, class: css }, svg), before);
    const text = (attributes, css, written) => { svg.insertBefore(make("text", { ...attributes, class: css }, svg), before).textContent = written; };
    const pairs = custom.length ? custom.map(([v, t]) => [+v, t]).filter(([v]) => v >= x.low && v <= x.high) : [];
    if (across && pairs.length < 2) pairs.splice(0, 9, ...ticks(x.low, x.high, width < NARROW ? Math.min(across, 5) : across, x.log).map((v) => [v, tickWords(v)]));
    for (const [v, written] of pairs) {
      const at = x.place(v);
      line({ x1: at, x2: at, y1: y.end, y2: y.start }, "grid across");
      if (height - y.start > 16) text({ x: at, y: y.start + 15, "text-anchor": "middle" }, "tick across", written);
    }
    for (const v of up ? ticks(y.low, y.high, up, y.log) : []) {
      const at = y.place(v);
      line({ x1: x.start, x2: x.end, y1: at, y2: at }, "grid upright");
      text({ x: x.start - 6, y: at + 4, "text-anchor": "end" }, "tick upright", tickWords(v));
    }
  };
  const redraw = (panel) => {
    for (const mark of all("path, line, rect, image, circle, text, g[transform]", panel.marks)) {
      if (mark.parentNode.closest("g[transform]")) continue;
      if (!bases.has(mark)) bases.set(mark, Object.fromEntries(NAMES[mark.tagName].filter((name) => mark.hasAttribute(name)).map((name) => [name, mark.getAttribute(name)])));
      fit(panel, mark);
    }
    if (panel.area) drawAxes(panel);
    const back = find(".whole", panel.svg.closest("figure") ?? document);
    if (back) back.hidden = !all("svg.panel", panel.svg.closest("figure")).some((svg) => panels.get(svg)?.zoomed);
  };
  const zoomTo = (panel, x, y) => {
    for (const [axis, wanted] of [["x", x], ["y", y]]) {
      const { start, end, log } = panel[axis], base = panel.base[axis];
      if (wanted === null) panel[axis] = start === base.start && end === base.end ? base : scale(base.low, base.high, start, end, log);
      else {
        const [low, high] = wanted, span = (s) => (log ? Math.log(s[1] / s[0]) : s[1] - s[0]);
        if (high > low && span([base.low, base.high]) / span(wanted) < MOST_ZOOM) panel[axis] = scale(low, high, start, end, log);
      }
    }
    panel.zoomed = x !== null || y !== null;
    redraw(panel);
  };
  /* A broad drawing on a narrow page is drawn narrow, so that its words can be read. */
  const layOut = (panel) => {
    const room = panel.svg.clientWidth, width = room && room < NARROW ? Math.max(room, 380) : panel.drawn;
    if (width === panel.width) return;
    panel.width = width;
    const end = width - (panel.drawn - panel.base.x.end), { low, high, start, log } = panel.x;
    panel.x = width === panel.drawn && !panel.zoomed ? panel.base.x : scale(low, high, start, end, log);
    panel.svg.setAttribute("viewBox", `0 0 ${width} ${panel.height}`);
    [panel.area, find("clipPath rect", panel.svg)].forEach((rect) => rect?.setAttribute("width", end - start));
    const { start: bottom, end: top } = panel.y;
    find(":scope > .axis", panel.svg)?.setAttribute("d", `M${start} ${top}L${start} ${bottom}L${end} ${bottom}`);
    const name = find(":scope > .name:not([transform])", panel.svg);
    if (name) name.setAttribute("x", (start + end) / 2);
    redraw(panel);
  };
  const pointed = (svg, event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  const inside = ({ x, y }, at) => at.x >= x.start && at.x <= x.end && at.y >= Math.min(y.end, y.start) && at.y <= Math.max(y.start, y.end);

  // ---------------------------------------------------------------- zoom by dragging and by keys
  let dragged = false;
  for (const panel of panels.values()) {
    const { svg, area } = panel;
    if (!area) continue;
    set(svg, { tabindex: 0, role: "group", "aria-roledescription": "plot", "aria-keyshortcuts": "+ - 0 Shift+ArrowLeft Shift+ArrowRight Shift+ArrowUp Shift+ArrowDown" });
    let from = null, box = null;
    const within = ({ x, y }, at) => ({ x: Math.min(Math.max(at.x, x.start), x.end), y: Math.min(Math.max(at.y, y.end), y.start) });
    svg.addEventListener("pointerdown", (event) => {
      const at = pointed(svg, event);
      dragged = false;
      if (event.button === 0 && event.pointerType !== "touch" && inside(panel, at)) from = at;
    });
    svg.addEventListener("pointermove", (event) => {
      if (!from) return;
      const to = within(panel, pointed(svg, event)), wide = Math.abs(to.x - from.x), tall = Math.abs(to.y - from.y);
      if (!box && Math.max(wide, tall) < 8) return;
      if (!box) svg.setPointerCapture(event.pointerId);
      box ??= make("rect", { class: "zoom-box" }, svg);
      dragged = true;
      const { x, y } = panel;  // a drag along one axis zooms that one
      set(box, { x: wide < 8 ? x.start : Math.min(from.x, to.x), y: tall < 8 ? y.end : Math.min(from.y, to.y), width: wide < 8 ? x.end - x.start : wide, height: tall < 8 ? y.start - y.end : tall });
    });
    const done = (event) => {
      if (box && event.type === "pointerup") {
        const [left, top, width, height] = ["x", "y", "width", "height"].map((name) => +box.getAttribute(name));
        const { x, y } = panel;
        zoomTo(panel, [x.number(left), x.number(left + width)], [y.number(top + height), y.number(top)]);
      }
      box?.remove();
      from = box = null;
    };
    svg.addEventListener("pointerup", done);
    svg.addEventListener("pointercancel", done);
    svg.addEventListener("dblclick", () => zoomTo(panel, null, null));
    svg.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const keys = { "+": 2 / 3, "=": 2 / 3, "-": 1.5, "−": 1.5 }, steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const factor = keys[event.key], step = event.shiftKey && steps[event.key];
      const part = ({ start, end, number }, share, size) => {
        const middle = (start + end) / 2 + (share * Math.abs(end - start)) / 5, half = (Math.abs(end - start) * size) / 2;
        return [number(middle - half), number(middle + half)].sort((a, b) => a - b);
      };
      if (event.key === "0") zoomTo(panel, null, null);
      else if (factor || step) zoomTo(panel, part(panel.x, step ? step[0] : 0, factor ?? 1), part(panel.y, step ? step[1] : 0, factor ?? 1));
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  // ---------------------------------------------------------------- legends that hide, files
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const selector = (item) => `.panel .${item.dataset.key.split(" ").map((name) => CSS.escape(name)).join(".")}`;
  const keyed = (item) => (item.dataset.key ? all(selector(item), item.closest("figure")) : []);
  const hide = (figure) => all(".legend li[role]", figure).forEach((item) => keyed(item).forEach((mark) => mark.classList.toggle("hidden-mark", item.getAttribute("aria-pressed") === "false")));
  const legend = (figure) => all(".legend li[data-key]", figure).filter((item) => !item.hasAttribute("role") && keyed(item).length).forEach((item) => {
    set(item, { role: "button", tabindex: 0, "aria-pressed": true });
    item.parentNode.setAttribute("role", "group");
    const toggle = () => { item.setAttribute("aria-pressed", item.getAttribute("aria-pressed") === "false"); hide(figure); };
    item.addEventListener("click", toggle);
    item.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") event.preventDefault(), event.stopPropagation(), toggle(); });
  });
  const save = (name, blob) => {
    const anchor = document.createElement("a");
    anchor.href = URL.createObjectURL(blob);
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
  };
  const LOOKS = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin", "opacity", "font-size", "font-weight", "font-family", "text-anchor", "paint-order", "vector-effect"];
  const styled = (original) => {
    const copy = original.cloneNode(false), look = getComputedStyle(original);
    if (look.display === "none" && original.tagName !== "clipPath") return null;
    if (original.tagName === "use") return styled(find(original.getAttribute("href")));
    for (const { name } of [...copy.attributes]) if (/^(class|data-|aria-|role|tabindex)/.test(name)) copy.removeAttribute(name);
    if (!/^(clipPath|g|svg)$/.test(original.tagName)) copy.setAttribute("style", LOOKS.map((name) => `${name}:${look.getPropertyValue(name)}`).join(";"));
    for (const child of original.childNodes) {
      const made = child.nodeType === Node.TEXT_NODE ? child.cloneNode() : styled(child);
      if (made) copy.append(made);
    }
    return copy;
  };
  /* The figure as it stands on the page, as a document of its own: hidden curves, zoom, instant and colours included. */
  const document_of = (figure) => {
    const drawings = all("svg.panel, svg.sketch", figure), shown = [...drawings, ...all(".legend li", figure)].map((part) => part.getBoundingClientRect());
    const left = Math.min(...shown.map((r) => r.left)) - 8, top = Math.min(...shown.map((r) => r.top)) - 8;
    const width = Math.max(...shown.map((r) => r.right)) - left + 8, height = Math.max(...shown.map((r) => r.bottom)) - top + 8;
    const root = set(document.createElementNS(SVG, "svg"), { xmlns: SVG, width, height, viewBox: `0 0 ${width} ${height}` });
    make("rect", { width, height, fill: getComputedStyle(figure).backgroundColor }, root);
    const placed = (svg) => {
      const box = svg.getBoundingClientRect();
      root.append(set(styled(svg), { x: box.left - left, y: box.top - top, width: box.width, height: box.height }));
    };
    drawings.forEach(placed);
    all(".legend li", figure).filter((item) => item.getAttribute("aria-pressed") !== "false").forEach((item) => {
      placed(find("svg", item));
      const box = find("span", item).getBoundingClientRect(), look = getComputedStyle(item);
      const text = make("text", { x: box.left - left, y: box.top - top + box.height * 0.75, style: `font-size:${look.fontSize};font-family:${look.fontFamily};fill:${look.color}` }, root);
      for (const part of find("span", item).childNodes) make("tspan", part.nodeName === "SUB" ? { "font-size": "75%" } : {}, text).textContent = part.textContent;
    });
    return { text: new XMLSerializer().serializeToString(root), width, height };
  };
  const picture = ({ text, width, height }) => new Promise((resolve, reject) => {
    const image = new Image(), factor = 3;
    image.onload = () => {
      const canvas = Object.assign(document.createElement("canvas"), { width: factor * width, height: factor * height });
      canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
      canvas.toBlob(resolve, "image/png");
    };
    image.onerror = reject;
    image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(text);
  });
  for (const figure of all("figure")) {
    const files = find(".files", figure), button = (words, css, action) => {
      const made = Object.assign(document.createElement("button"), { type: "button", textContent: words, className: css });
      made.addEventListener("click", action);
      files.append(" ", made);
      return made;
    };
    legend(figure);
    if (!files || !find("svg.panel, svg.sketch", figure)) continue;
    const name = find("[data-csv]", figure)?.dataset.csv ?? figure.id;
    all("[data-made]", files).forEach((link) => link.remove());
    button("SVG", "link", () => save(`${name}.svg`, new Blob([document_of(figure).text], { type: "image/svg+xml" })));
    button("PNG", "link", async () => save(`${name}.png`, await picture(document_of(figure))));
    button("Whole view", "link whole", () => all("svg.panel", figure).forEach((svg) => panels.get(svg)?.zoomed && zoomTo(panels.get(svg), null, null))).hidden = true;
  }

  // ---------------------------------------------------------------- nothing is wider than its column
  const tables = all(".wide > table");
  for (const table of tables) {
    const heads = all("thead th", table).map((head) => head.textContent.trim());
    all("tbody tr", table).forEach((row) => [...row.cells].forEach((cell, k) => { if (heads[k]) cell.dataset.head = heads[k]; }));
  }
  const arrange = () => {
    tables.forEach((table) => table.classList.remove("stacked"));
    tables.filter((table) => table.scrollWidth > table.parentNode.clientWidth + 1).forEach((table) => table.classList.add("stacked"));
    panels.forEach((panel) => { if (panel.drawn >= NARROW && !panel.svg.classList.contains("equal")) layOut(panel); });
  };
  document.documentElement.classList.add("scripted-page");
  arrange();
  addEventListener("resize", arrange);
  all("details").forEach((details) => details.addEventListener("toggle", arrange));
  /* A link to what is folded opens it. */
  const unfold = () => {
    const place = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!place) return;
    const folded = [place.closest("details"), find("details", place)].filter((details) => details && !details.open);
    folded.forEach((details) => { details.open = true; });
    if (folded.length) place.scrollIntoView();
  };
  addEventListener("hashchange", unfold);
  unfold();

  // ---------------------------------------------------------------- numbers under the pointer
  const hint = document.body.appendChild(Object.assign(document.createElement("div"), { id: "hint", hidden: true }));
  hint.setAttribute("role", "status");
  const parsed = new WeakMap();
  const pointsOf = (path) => {
    const text = path.getAttribute("d"), kept = parsed.get(path);
    if (kept && kept.text === text) return kept.points;
    const points = text.slice(1).split(/[ML]/).map((pair) => pair.split(" ").map(parseFloat));
    parsed.set(path, { text, points });
    return points;
  };
  const under = (svg, at) => {
    const axes = panels.get(svg), rows = new Set();
    for (const path of all("path.curve[data-label]:not(.hidden-mark)", svg)) {
      const points = pointsOf(path), rising = points.every((p, k) => !k || p[0] >= points[k - 1][0]);
      const far = (p) => (rising && points.length > 2 ? Math.abs(p[0] - at.x) : Math.hypot(p[0] - at.x, p[1] - at.y));
      const best = points.reduce((a, b) => (far(b) < far(a) ? b : a));
      if (far(best) > 14) continue;
      const up = axes.y.number(best[1]), label = path.dataset.label;
      rows.add(rising ? `${label}: ${words(up)}` : `${label}: (${words(axes.x.number(best[0]))}, ${words(up)})`);
    }
    return [...rows];
  };
  let special = () => null;  // rows of panels that only a cycle has
  const hintRows = (svg, at, target) => {
    if (target.dataset.label && target.tagName !== "path") return [target.dataset.label];
    const panel = panels.get(svg), across = panel.x.number(at.x), found = special(svg, across, panel.y.number(at.y));
    if (found) return found;
    const rows = under(svg, at);
    return rows.length ? [`${svg.dataset.xWords || "x / a_ref"}: ${words(across)}`, ...rows] : [];
  };
  for (const [svg, panel] of panels) {
    svg.addEventListener("pointermove", (event) => {
      const at = pointed(svg, event), rows = inside(panel, at) ? hintRows(svg, at, event.target) : [];
      hint.hidden = !rows.length;
      hint.replaceChildren(...rows.map((row) => typeset(document.createElement("div"), row)));
      const room = hint.getBoundingClientRect();
      hint.style.left = `${Math.max(4, Math.min(event.clientX + 14, innerWidth - room.width - 6))}px`;
      hint.style.top = `${event.clientY + 18 + room.height > innerHeight ? event.clientY - room.height - 10 : event.clientY + 18}px`;
    });
    svg.addEventListener("pointerleave", () => { hint.hidden = true; });
  }
  addEventListener("scroll", () => { hint.hidden = true; }, { passive: true });

  // ---------------------------------------------------------------- a cycle
  const data = JSON.parse(find("#cycle-data")?.textContent ?? "{}");
  all("a[data-csv]").filter((link) => link.dataset.csv in (data.tables ?? {})).forEach((link) => link.addEventListener("click", async (event) => {
    if (typeof DecompressionStream === "undefined") return;
    event.preventDefault();
    const stream = new Blob([bytes(data.tables[link.dataset.csv])]).stream().pipeThrough(new DecompressionStream("deflate"));
    save(`${link.dataset.csv}.csv`, new Blob([await new Response(stream).text()], { type: "text/csv" }));
  }));
  if (!data.instants) return;
  const n = data.points, count = data.instants, { series, x } = data;
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
  const panelOf = (mark) => panels.get(mark.closest("svg"));
  const curves = all("path[data-field]").map((path) => ({ path, panel: panelOf(path), name: path.dataset.field }));
  const strips = all("g.strip").map((group) => ({ group, panel: panelOf(group), engine: +group.dataset.strip }));
  const rings = all("circle.follow").map((ring) => ({ ring, panel: panelOf(ring), at: ring.dataset }));
  const cursors = all('svg[data-time="x"], svg[data-time="y"]').map((svg) => {
    const panel = panels.get(svg), upright = svg.dataset.time === "x", { x: across, y: up } = panel.base;
    const ends = upright ? { y1: up.start, y2: up.end } : { x1: across.start, x2: across.end };
    return { panel, mark: set(make("line", { class: "cursor" }, panel.marks), ends), axis: upright ? across : up, names: upright ? ["x1", "x2"] : ["y1", "y2"] };
  });
  const slider = find("#instant"), readout = find("#readout"), play = find("#play"), chips = find("#events");
  const measures = all("#panel-now-difference > .measure"), lengths = x.map((_, i) => (x[Math.min(i + 1, n - 1)] - x[Math.max(i - 1, 0)]) / (i && i < n - 1 ? 2 : 1));
  let now = 0;

  const drawStrip = ({ group, panel, engine }) => {
    group.replaceChildren();
    const { x: across } = panel.base;
    let start = across.start;
    for (let i = 0; i < n; i++) {
      const state = stateOf(engine, now, i);
      if (i + 1 < n && stateOf(engine, now, i + 1) === state) continue;
      const middle = i + 1 < n ? across.place((x[i] + x[i + 1]) / 2) : across.end;
      const end = Math.min(Math.max(middle, across.start), across.end);
      if (end > start) put(panel, make("rect", {}, group), { x: start, y: group.dataset.top, width: end - start, height: 16, class: `state-${state}` });
      start = end;
    }
  };
  /* The same numbers as beside the plots that stand still: over the points where either body carries pressure. */
  const measure = (key) => {
    let square = 0, length = 0, worst = -1;
    for (let i = 0; i < n; i++) {
      const d = value(`d${key}`, now, i);
      if (!Number.isFinite(d) || (value("p0", now, i) === 0 && value("p1", now, i) === 0)) continue;
      square += d * d * lengths[i];
      length += lengths[i];
      if (worst < 0 || Math.abs(d) > Math.abs(value(`d${key}`, now, worst))) worst = i;
    }
    if (worst < 0) return `${key}: nothing to compare`;
    return `${key}: rms ${words(Math.sqrt(square / length), 2)} %, largest ${words(value(`d${key}`, now, worst), 2)} % at x = ${words(x[worst], 3)} a_ref`;
  };
  const show = (k) => {
    now = Math.min(Math.max(k, 0), count - 1);
    const indices = x.map((_, i) => i);
    for (const { path, panel, name } of curves) put(panel, path, { d: line(panel.base, x, indices.map((i) => value(name, now, i))) });
    strips.forEach(drawStrip);
    for (const { ring, panel, at } of rings) {
      const [across, up] = [series[at.seriesX][now], series[at.seriesY][now]], there = across !== null && up !== null;
      ring.style.display = there ? "" : "none";
      if (there) put(panel, ring, { cx: panel.base.x.place(across), cy: panel.base.y.place(up) });
    }
    for (const { panel, mark, axis, names } of cursors) put(panel, mark, Object.fromEntries(names.map((name) => [name, axis.place(series.t[now])])));
    measures.forEach((text, which) => typeset(text, measure("pq"[which])));
    const event = data.events.find(([row]) => row === now);
    const text = `${data.time_words} ${words(series.t[now])} · P ${words(series.P[now])} · Q ${words(series.Q[now])} ${data.load_unit}`;
    slider.value = now;
    slider.setAttribute("aria-valuetext", event ? `${text}, ${event[1]}` : text);
    readout.textContent = text;
    all("button", chips).forEach((chip, which) => chip.setAttribute("aria-pressed", String(data.events[which][0] === now)));
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
    play.setAttribute("aria-label", on ? "Stop" : `Play the ${(data.stretch ?? "cycle").split(" ").pop()}`);
  };
  const go = (k) => { setPlaying(false); show(k); };
  slider.max = count - 1;
  slider.addEventListener("input", () => go(+slider.value));
  play.addEventListener("click", () => setPlaying(!playing));
  data.events.forEach(([row, label], k) => {
    const chip = Object.assign(document.createElement("button"), { type: "button", textContent: `${k + 1} ${label}` });
    chip.addEventListener("click", () => go(row));
    chips.append(chip);
  });
  const typed = (target) => target.matches("input:not(#instant), textarea, select");
  document.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey || typed(event.target)) return;
    const within = event.target.closest("#through") !== null, free = event.target === document.body;
    const steps = { ArrowLeft: now - 1, ArrowRight: now + 1, ArrowDown: now - 1, ArrowUp: now + 1, Home: 0, End: count - 1, PageDown: now - 10, PageUp: now + 10 };
    const onSlider = event.target === slider;
    if (event.key === " " && (onSlider || (within && !event.target.matches("button, a, summary")))) setPlaying(!playing);
    else if (onSlider && event.key in steps) go(steps[event.key]);
    else if ((within || free) && (event.key === "ArrowLeft" || event.key === "ArrowRight") && !event.target.matches(".wide")) go(steps[event.key]);
    else return;
    event.preventDefault();
  });
  all(".cell[data-event]").forEach((cell) => cell.addEventListener("click", () => { if (!dragged) go(nearest(data.rows, +cell.dataset.event)); }));

  // ---------------------------------------------------------------- slip of chosen points
  const slip = panels.get(find("#panel-slip")), form = find("#choose");
  let chosen = [...data.slip_points];
  const drawSlip = () => {
    const slips = chosen.map((i) => [0, 1].map((engine) => series.t.map((_, k) => value(`s${engine}`, k, i) - value(`s${engine}`, 0, i))));
    const everything = slips.flat(2).filter(Number.isFinite).concat(0), first = chosen.join() === data.slip_points.join();
    const [low, high] = [Math.min(...everything), Math.max(...everything)], room = 0.06 * (high - low || 1), old = slip.y;
    slip.y = slip.base.y = scale(low - room, high + room, old.start, old.end, false);
    drawAxes(slip);
    all(".curve", slip.marks).forEach((mark) => mark.remove());
    for (const engine of [0, 1]) slips.forEach((pair, k) => add(slip, "path", {
      d: line(slip.base, series.t, pair[engine]), class: `curve ${engine ? "thin" : "wide"} point-${k}`,
      "data-label": `x = ${words(x[chosen[k]])} a_ref, ${data.engines[engine]}`,
    }));
    all("#panel-slip > .measure").forEach((text) => { text.style.display = first ? "" : "none"; });
    find("#slip_history .legend").replaceChildren(...chosen.map((i, k) => {
      const item = document.createElement("li"), sample = document.createElementNS(SVG, "svg");
      item.dataset.key = `point-${k}`;
      make("path", { d: "M1 6H25", class: `curve thin point-${k}` }, item.appendChild(set(sample, { viewBox: "0 0 26 12" })));
      item.append(typeset(document.createElement("span"), `x = ${words(x[i])} a_ref`));
      return item;
    }));
    legend(find("#slip_history"));
    all(".pick-line").forEach((mark) => mark.remove());
    for (const svg of all("svg.pick")) chosen.forEach((i, k) => {
      const panel = panels.get(svg), at = panel.base.x.place(x[i]), { start, end } = panel.base.y;
      add(panel, "line", { x1: at, x2: at, y1: start, y2: end, class: `pick-line point-${k}` });
    });
  };
  const choose = (place) => {
    const i = nearest(x, place);
    chosen = chosen.includes(i) ? chosen.filter((other) => other !== i) : [...chosen, i].slice(-MOST_PLACES);
    if (!chosen.length) chosen = [i];
    drawSlip();
  };
  if (slip && form) {
    all("svg.pick").forEach((svg) => svg.addEventListener("click", (event) => {
      const panel = panels.get(svg), at = pointed(svg, event);
      if (!dragged && inside(panel, at)) choose(panel.x.number(at.x));
    }));
    form.addEventListener("submit", (event) => { event.preventDefault(); const at = find("#place").valueAsNumber; if (Number.isFinite(at)) choose(at); });
    find("#clear").addEventListener("click", () => { chosen = [...data.slip_points]; drawSlip(); });
    form.hidden = false;
    drawSlip();
  }
  const stateRows = (k, i) => data.engines.map((name, engine) => `${name}: ${STATE_WORDS[stateOf(engine, k, i)]}`);
  special = (svg, across, up) => {
    if (svg.id === "panel-zones") return [`x / a_ref: ${words(across)}`, ...stateRows(now, nearest(x, across))];
    if (svg.dataset.time === "y") return [`x / a_ref: ${words(across)}`, `${data.time_words}: ${words(up)}`, ...stateRows(nearest(series.t, up), nearest(x, across))];
    return null;
  };
  find("#controls").hidden = false;
  show(data.start);
})();
