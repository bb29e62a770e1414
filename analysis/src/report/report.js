// Plots that respond to the pointer.
const COLORS = 7, MOST_CURVES = 14, REACH_PX = 60, TEXT_PX = 12, DRAG_PX = 8, PRINT_WIDTH_PX = 350, ENTRY_PX = 24, LEAST_TICK_PX = 32, GROWTH = 30, CHART_FRAME_PX = 112, LEAST_CAPTION_PX = 11;
let isPrinted = false;

function set(target, attributes) {
  for (const [key, value] of Object.entries(attributes)) target.setAttribute(key, value);
}

function element(name, attributes, parent, text) {
  const isSvg = /^(svg|g|path|line|rect|text|tspan|circle|clipPath)$/.test(name);
  const made = isSvg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  set(made, attributes);
  if (text !== undefined) made.textContent = text;
  // Boltzmann's constant has a subscript.
  if (name === "text" && text?.endsWith("(k_B)")) {
    made.textContent = text.slice(0, -3);
    element("tspan", { dy: "0.25em", "font-size": "75%" }, made, "B");
    element("tspan", { dy: "-0.19em" }, made, ")");
  }
  if (parent) parent.append(made);
  return made;
}

// Text that does not fit is condensed.
function condense(text, room) {
  if (text.getComputedTextLength() > room) set(text, { textLength: room, lengthAdjust: "spacingAndGlyphs" });
}

const ruler = document.createElement("canvas").getContext("2d");
function widthOf(text, size) {
  ruler.font = `${size}px system-ui, sans-serif`;
  return ruler.measureText(text).width;
}

// Multiples of 1, 2 or 5 times a power of ten.
function evenTicks(low, high, count) {
  const rough = (high - low) / count, unit = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * unit).find((each) => each >= rough * (1 - 1e-9));
  const ticks = [];
  for (let index = Math.ceil(low / step); index * step <= high; index++) ticks.push(index * step);
  return { ticks, step };
}

// Ticks: places (logarithms on a logarithmic axis) and texts, and the power of ten of the caption.
function ticksOf(axis, isLog, low, high, count) {
  if (axis.words) {
    const shown = axis.words.map((text, at) => ({ at, text })).filter(({ at }) => at >= low && at <= high);
    const stride = max(1, Math.ceil(shown.length / count));
    return { ticks: shown.filter((_, index) => index % stride === 0), exponent: 0 };
  }
  if (!isLog) {
    const size = max(Math.abs(low), Math.abs(high));
    const exponent = size >= 1e-2 && size < 1e5 ? 0 : exponentOf(size);
    const { ticks, step } = evenTicks(low, high, count);
    const decimals = clamp(-exponentOf(step / 10 ** exponent), 0, 15);
    const text = (tick) => (tick / 10 ** exponent).toFixed(decimals).replace("-", "−").replace(/^−(0\.?0*)$/, "$1");
    return { ticks: ticks.map((tick) => ({ at: tick, text: text(tick) })), exponent };
  }
  const within = (mantissas, stride) => {
    const all = [];
    for (let decade = Math.floor(low / stride) * stride; decade <= high; decade += stride) all.push(...mantissas.map((mantissa) => decade + Math.log10(mantissa)));
    return all.filter((place) => place >= low && place <= high);
  };
  // The finest ticks that are not too many.
  let places = [[1, 2, 5], [1, 3], [1]].map((mantissas) => within(mantissas, 1)).find((all) => all.length <= 1.5 * count);
  for (let stride = 2; !places; stride++) if (within([1], stride).length <= 1.5 * count) places = within([1], stride);
  if (within([1, 2, 5], 1).length < 3) places = evenTicks(10 ** low, 10 ** high, count).ticks.filter((tick) => tick > 0).map(Math.log10);
  return { ticks: places.map((at) => ({ at, text: number(10 ** at, 0, 4) })), exponent: 0 };
}

let charts = [], count = 0;

// A chart that responds to the pointer.
function chart(figure, data) {
  const { x: xAxis, y: yAxis, curves } = data, id = `plot-area-${count++}`;
  for (const curve of curves) if (typeof curve.x === "number") curve.x = curves[curve.x].x;
  const hidden = new Set();
  let isLogX = xAxis.log, isLogY = yAxis.log, zoom = null, view = null, at = null, drag = null;
  for (const old of figure.querySelectorAll(":scope > :not(script)")) old.remove();
  element("figcaption", {}, figure, data.title);
  const legend = element("div", { class: "legend" }, figure), tools = element("div", { class: "tools" }, figure);
  const plane = element("div", { class: "plane" }, figure), sheet = element("svg", { class: "sheet", role: "img", tabindex: 0, "aria-label": data.title }, plane);
  const remark = element("p", { class: "remark" }, figure);
  const tip = element("div", { class: "tip", role: "status", hidden: "" }, figure);

  // Each area lies on the one before it.
  let below = null;
  for (const curve of curves.filter(({ style }) => style === "area")) {
    curve.below = below ? below.y : curve.x.map(() => 0);
    below = curve;
  }
  // The first theory or fit that is named after its curve shares the entry of that curve.
  const isComparison = ({ style }) => style === "theory" || style === "fit";
  const sharing = ({ name, color }) => curves.filter((line) => isComparison(line) && line.color === color && line.name.startsWith(`${name}: `));
  const measured = (line) => isComparison(line) && curves.find((curve) => !isComparison(curve) && curve.name && sharing(curve).includes(line) && sharing(curve)[0].style === line.style);
  // Lower end of a logarithmic axis of lines that grow: their first value, the precision of an error.
  function floorOf() {
    if (curves.some(({ style }) => style !== "line")) return -Infinity;
    const floors = curves.map(({ y }) => y.filter((value) => value > 0)).filter(({ length }) => length > 1).map(([first, ...rest]) => {
      const [least, greatest] = [min(...rest), max(...rest)];
      return greatest > GROWTH * first ? first : min(least, first);
    });
    return floors.length ? Math.log10(min(...floors)) : -Infinity;
  }
  // Colors repeat with another mark or dash.
  const strokeOf = (curve) => ({ class: `curve ${curve.style} round${Math.floor(curve.color / COLORS)}`, style: `stroke:var(--c${curve.color % COLORS});color:var(--c${curve.color % COLORS})` });
  const showable = (value, isLog) => Number.isFinite(value) && (!isLog || value > 0);
  const place = (value, isLog) => isLog ? Math.log10(value) : value;
  const shown = () => curves.filter((curve) => !hidden.has(curve));
  const hasLog = (of) => {
    const values = curves.flatMap(of).filter(Number.isFinite);
    return !data.equal && values.length > 1 && values.filter((value) => value > 0).length >= 0.9 * values.length;
  };

  // The range of the visible points with their error bars, and a margin.
  function range(of, isLog, isY) {
    let low = Infinity, high = -Infinity;
    for (const [values, errors] of (shown().length ? shown() : curves).map(of)) values.forEach((value, i) => {
      const error = errors[i] || 0, ends = value === null ? [] : [value - error, value, value + error];
      for (const end of ends.filter((end) => showable(end, isLog))) {
        low = min(low, place(end, isLog));
        high = max(high, place(end, isLog));
      }
    });
    if (low > high) [low, high] = [0, 1];
    if (isLog && isY) low = min(high, max(low, floorOf()));
    if (!isLog && isY && below) low = min(low, 0);
    const size = max(Math.abs(low), Math.abs(high));
    const missing = high - low > 1e-9 * size ? 0 : size ? 0.01 * size : 0.5, margin = 0.05 * (high - low + 2 * missing);
    return [low - missing - margin, high + missing + margin];
  }

  function ranges(shape) {
    if (zoom) return zoom;
    const x = range((curve) => [curve.x, []], isLogX), y = range((curve) => [curve.y, curve.e], isLogY, true);
    if (data.equal) {
      const extra = (y[1] - y[0]) * shape - (x[1] - x[0]);
      const [wider, by] = extra > 0 ? [x, extra / 2] : [y, -extra / shape / 2];
      wider[0] -= by;
      wider[1] += by;
    }
    return [x, y];
  }

  // Pixels of places on the axes, and of values.
  const acrossOf = (at) => view.left + (at - view.x[0]) / (view.x[1] - view.x[0]) * view.width;
  const downOf = (at) => view.top + (view.y[1] - at) / (view.y[1] - view.y[0]) * view.height;
  const px = (value) => acrossOf(place(value, isLogX));
  const py = (value) => downOf(place(value, isLogY));
  const isShowable = (curve, i) => showable(curve.x[i], isLogX) && showable(curve.y[i], isLogY);

  function drawCurve(curve, parent) {
    let path = "", isDown = false, bars = "";
    for (let i = 0; i < curve.x.length; i++) {
      if (!isShowable(curve, i)) { isDown = false; continue; }
      const [left, top] = [px(curve.x[i]), py(curve.y[i])].map((part) => clamp(part, -1e5, 1e5).toFixed(1));
      const isLevel = xAxis.words && curve.style === "theory";
      path += isLevel ? `M${left - 15} ${top}h30` : isDown && curve.style !== "data" ? `L${left} ${top}` : `M${left} ${top}h.01`;
      isDown = true;
      const error = curve.e[i];
      if (!(error > 0)) continue;
      const upper = py(curve.y[i] + error).toFixed(1), low = curve.y[i] - error;
      const lower = (showable(low, isLogY) ? py(low) : view.top + view.height).toFixed(1);
      bars += `M${left} ${upper}V${lower}M${left - 4} ${upper}h8M${left - 4} ${lower}h8`;
    }
    if (curve.below && path) for (let i = curve.x.length; i--;) path += `L${px(curve.x[i]).toFixed(1)} ${py(curve.below[i]).toFixed(1)}`;
    element("path", { ...strokeOf(curve), d: path }, parent);
    if (bars) element("path", { ...strokeOf(curve), class: "curve bars", d: bars }, parent);
  }

  function captionOf(axis, exponent) {
    const power = exponent ? `10${superscript(exponent)}` : "", unit = [power, axis.unit].filter(Boolean).join(" ");
    return unit ? `${axis.label} (${unit})` : axis.label;
  }

  function caption(text, attributes, room) {
    const size = clamp(13 * room / widthOf(text, 13), LEAST_CAPTION_PX, 13);
    condense(element("text", { "text-anchor": "middle", style: `font-size:${size}px`, ...attributes }, sheet, text), room);
  }

  // A text in one line, or in the two most equal ones if it has no room at its smallest size.
  function linesOf(text, room) {
    const words = text.split(" "), width = (line) => widthOf(line, LEAST_CAPTION_PX), longest = (lines) => max(...lines.map(width));
    let best = [text];
    if (width(text) > room) words.forEach((_, i) => {
      const lines = [words.slice(0, i).join(" "), words.slice(i).join(" ")];
      if (longest(lines) < longest(best)) best = lines;
    });
    return best;
  }

  // Two charts next to the replay share the height of the window, so that its lower edge cuts none. Each has a title, a legend and buttons as well.
  function heightOf(full) {
    if (data.equal) return min(0.9 * full, 560);
    const usual = clamp(0.58 * full, 260, 400), column = figure.closest(".adjacent");
    const isShared = !isPrinted && innerWidth >= 860 && column?.querySelectorAll("figure:not(.live)").length === 2;
    const top = isShared ? column.getBoundingClientRect().top + scrollY : 0;
    return isShared ? clamp((innerHeight - top) / 2 - CHART_FRAME_PX - (data.remark ? 24 : 0), 170, usual) : usual;
  }

  function draw() {
    const full = isPrinted ? PRINT_WIDTH_PX : clamp(figure.clientWidth, 240, 760);
    const height = heightOf(full);
    const top = 10, lines = xAxis.words ? 2 : 1, bottom = 32 + 14 * lines, right = 16 + endMargin(full, height - bottom);
    const [x, y] = ranges((full - 70) / (height - top - bottom));
    const rows = ticksOf(yAxis, isLogY, ...y, max(2, (height - top - bottom) / 45));
    const room = height - bottom + top - 4, upright = linesOf(captionOf(yAxis, rows.exponent), room);
    const left = 16 + 14 * upright.length + Math.ceil(max(LEAST_TICK_PX, ...rows.ticks.map(({ text }) => widthOf(text, TEXT_PX))));
    view = { x, y, left, top, width: full - left - right, height: height - top - bottom };
    let columns, amount = max(2, lines * Math.floor(view.width / 70));
    // Words are in two lines by turns.
    const isCrowded = ({ ticks }) => ticks.slice(lines).some((tick, i) => acrossOf(tick.at) - acrossOf(ticks[i].at)
      < (widthOf(tick.text, TEXT_PX) + widthOf(ticks[i].text, TEXT_PX)) / 2 + 10);
    do columns = ticksOf(xAxis, isLogX, ...x, amount); while (isCrowded(columns) && --amount >= 1);
    // No point is left out silently.
    const lost = shown().filter(({ style }) => style === "data").flatMap((curve) => curve.x.filter((at, i) =>
      Number.isFinite(at) && Number.isFinite(curve.y[i]) && !isShowable(curve, i))).length;
    const leftOut = lost ? `${lost} ${lost > 1 ? "points" : "point"} at 0 or below: not on a logarithmic axis` : "";
    remark.textContent = [data.remark, leftOut].filter(Boolean).join("; ");
    remark.hidden = !remark.textContent;
    sheet.replaceChildren();
    sheet.setAttribute("viewBox", `0 0 ${full} ${height}`);
    const box = { x: left, y: top, width: view.width, height: view.height }, foot = top + view.height;
    element("rect", box, element("clipPath", { id }, sheet));
    for (const [i, { at, text }] of columns.ticks.entries()) {
      const across = acrossOf(at), half = widthOf(text, TEXT_PX) / 2;
      element("line", { class: "grid", x1: across, x2: across, y1: top, y2: foot }, sheet);
      element("text", { x: min(across, full - half - 1), y: foot + 16 + 14 * (i % lines), "text-anchor": "middle" }, sheet, text);
    }
    for (const { at, text } of rows.ticks) {
      const down = downOf(at);
      element("line", { class: "grid", x1: left, x2: left + view.width, y1: down, y2: down }, sheet);
      element("text", { x: left - 6, y: clamp(down + 4, 12, foot), "text-anchor": "end" }, sheet, text);
    }
    const area = element("g", { "clip-path": `url(#${id})` }, sheet);
    for (const curve of shown()) drawCurve(curve, area);
    element("rect", { class: "frame", ...box }, sheet);
    placeEntries(full, height);
    caption(captionOf(xAxis, columns.exponent), { x: left + view.width / 2, y: height - 8 }, view.width + 28);
    upright.forEach((line, i) => caption(line, { transform: `translate(${14 + 14 * i} ${top + view.height / 2}) rotate(-90)` }, room));
    view.now = element("line", { class: "now", y1: top, y2: foot, visibility: "hidden" }, area);
    view.mark = element("circle", { class: "mark", r: 6, visibility: "hidden" }, area);
    view.zoom = element("rect", { class: "zoom", visibility: "hidden" }, sheet);
    reset.style.visibility = zoom ? "visible" : "hidden";
    showTime();
    point(at);
  }

  // The replay's time as a line, in charts of its run.
  const files = () => shown().map((curve) => curve.run?.file).filter(Boolean);
  function showTime() {
    if (!view) return;
    const replay = window.replay, isOn = data.time && replay && files().includes(replay.file) && showable(replay.time, isLogX);
    const x = isOn ? px(replay.time) : 0;
    set(view.now, { x1: x, x2: x, visibility: isOn ? "visible" : "hidden" });
  }

  function scrub(time) {
    if (!data.time || !window.replay) return;
    const all = files(), { file: current, has } = window.replay;
    const file = all.includes(current) ? current : all.find(has);
    if (file) window.replay.seek(time, file);
  }

  // Marks a point, as curve and index, and shows its values.
  function point(next) {
    at = next && !hidden.has(next[0]) && isShowable(...next) ? next : null;
    view.mark.setAttribute("visibility", at ? "visible" : "hidden");
    tip.hidden = !at;
    if (!at) return;
    const [curve, i] = at, left = px(curve.x[i]), top = py(curve.y[i]);
    set(view.mark, { cx: left, cy: top });
    const word = xAxis.words ? xAxis.words[curve.x[i]] : withUnit(number(curve.x[i]), xAxis.unit);
    const lines = [curve.name, `${xAxis.label} = ${word}`, `${yAxis.label} = ${withUnit(number(curve.y[i] - (curve.below ? curve.below[i] : 0), curve.e[i]), yAxis.unit)}`];
    if (curve.run && curve.run.name !== curve.name) lines.push(`run: ${curve.run.name}`);
    if (curve.runs) lines.push(curve.runs[i] === 1 ? "1 run" : `mean of ${curve.runs[i]} runs`);
    tip.textContent = lines.filter(Boolean).join("\n");
    const box = sheet.getBoundingClientRect(), frame = figure.getBoundingClientRect();
    const across = box.left - frame.left + left, down = box.top - frame.top + top;
    const isRight = across + 14 + tip.offsetWidth <= frame.width;
    tip.style.left = `${max(0, isRight ? across + 14 : across - 14 - tip.offsetWidth)}px`;
    tip.style.top = `${max(0, down - tip.offsetHeight - 8)}px`;
  }

  // The nearest visible point; a pointer follows x, so y counts less.
  function nearest([across, down]) {
    let found = null, least = REACH_PX;
    for (const curve of shown()) for (let i = 0; i < curve.x.length; i++) {
      if (!isShowable(curve, i)) continue;
      const [left, top] = [px(curve.x[i]), py(curve.y[i])];
      const distance = Math.hypot(left - across, 0.5 * (top - down));
      if (distance < least && left > view.left - 1 && left < view.left + view.width + 1) [found, least] = [[curve, i], distance];
    }
    return found;
  }

  const position = (event) => {
    const box = sheet.getBoundingClientRect(), scale = sheet.viewBox.baseVal.width / box.width;
    const [across, down] = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    return [clamp(across, view.left, view.left + view.width), clamp(down, view.top, view.top + view.height)];
  };
  const xAt = (across) => view.x[0] + (across - view.left) / view.width * (view.x[1] - view.x[0]);
  const yAt = (down) => view.y[1] - (down - view.top) / view.height * (view.y[1] - view.y[0]);

  const redraw = () => { if (view || isPrinted) draw(); };
  const setZoom = (next) => { zoom = next; redraw(); };

  // The sides of the rectangle that is dragged.
  const sidesTo = (to) => to.map((end, axis) => [drag[axis], end].sort((a, b) => a - b));
  const isWide = ([low, high]) => high - low >= DRAG_PX;

  on(sheet, "pointerdown", (event) => { if (event.button === 0) drag = position(event); });
  on(sheet, "pointermove", (event) => {
    const to = position(event);
    if (!drag) {
      point(nearest(to));
      scrub(isLogX ? 10 ** xAt(to[0]) : xAt(to[0]));
      return;
    }
    const sides = sidesTo(to);
    if (!sides.some(isWide)) return;
    if (event.isTrusted) sheet.setPointerCapture(event.pointerId);
    point(null);
    const [[left, right], [top, bottom]] = sides;
    set(view.zoom, { x: left, y: top, width: right - left, height: bottom - top, visibility: "visible" });
  });
  on(sheet, "pointerup", (event) => {
    if (!drag) return;
    const to = position(event), sides = sidesTo(to), [across, down] = sides;
    drag = null;
    if (!sides.some(isWide)) return point(nearest(to));
    setZoom([isWide(across) ? across.map(xAt) : view.x, isWide(down) ? down.map(yAt).reverse() : view.y]);
  });
  on(sheet, "pointercancel", () => { drag = null; draw(); });
  on(sheet, "pointerleave", () => { if (!drag) point(null); });
  on(sheet, "dblclick", () => setZoom(null));
  on(sheet, "blur", () => point(null));
  on(sheet, "keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key], turn = { ArrowUp: -1, ArrowDown: 1 }[event.key], all = shown();
    if (event.key === "Escape") setZoom(null);
    else if (!(step || turn) || !all.length) return;
    else if (!at) point([all[0], 0]);
    else if (turn) {
      const curve = all[(all.indexOf(at[0]) + turn + all.length) % all.length];
      point([curve, min(at[1], curve.x.length - 1)]);
    } else if (isShowable(at[0], at[1] + step)) point([at[0], at[1] + step]);
    if (at) scrub(at[0].x[at[1]]);
    event.preventDefault();
  });

  function toggle(parent, name, isOn, change) {
    const button = element("button", { type: "button", "aria-pressed": isOn() }, parent, name);
    on(button, "click", () => {
      change();
      button.setAttribute("aria-pressed", isOn());
      draw();
    });
    return button;
  }
  const reset = element("button", { type: "button" }, tools, "reset zoom");
  on(reset, "click", () => setZoom(null));
  if (!below && !xAxis.words && hasLog((curve) => curve.x)) toggle(tools, "log x", () => isLogX, () => { isLogX = !isLogX; zoom = null; });
  if (!below && (isLogY || hasLog((curve) => curve.y))) toggle(tools, "log y", () => isLogY, () => { isLogY = !isLogY; zoom = null; });

  const entries = curves.filter((curve) => curve.name && !measured(curve)).map((curve) => {
    const all = [curve, ...curves.filter((other) => measured(other) === curve)];
    const button = toggle(legend, "", () => !hidden.has(curve), () => {
      const isHidden = hidden.has(curve);
      all.forEach((each) => { if (isHidden) hidden.delete(each); else hidden.add(each); });
    });
    const sample = element("svg", { viewBox: "0 0 26 10", "aria-hidden": true }, button);
    for (const each of all) element("path", { ...strokeOf(each), d: each.style === "data" ? "M13 5h.01" : each.below ? "M0 1h26v8h-26" : "M0 5h26" }, sample);
    // A line that shows how steep a power law is has its slope in the text.
    const line = all[1]?.name, text = line?.includes(": slope") ? line.replace(": slope", ", slope") : curve.name;
    button.append(text);
    return { curve, button, text };
  });

  // Width of the margin for entries at the ends of their curves; 0 where they are in rows above the chart.
  function endMargin(full, height) {
    const width = 56 + max(0, ...entries.map(({ text }) => widthOf(text, 13)));
    const hasRoom = entries.length > 2 && !data.equal && !isPrinted && width < 0.42 * full && entries.length * ENTRY_PX < height;
    legend.classList.toggle("ends", hasRoom);
    // Moving it takes the keyboard's focus away.
    if (hasRoom !== (legend.parentElement === plane)) if (hasRoom) plane.append(legend); else tools.before(legend);
    return hasRoom ? width : 0;
  }

  // Places the entries at the heights of the ends of their curves, at distances of a row, in parts of the sheet.
  function placeEntries(full, height) {
    if (!legend.classList.contains("ends")) return;
    const placed = entries.map(({ curve, button }) => {
      const last = curve.x.reduce((best, x, i) => isShowable(curve, i) && (best < 0 || x >= curve.x[best]) ? i : best, -1);
      const value = last < 0 ? null : curve.below ? (curve.y[last] + curve.below[last]) / 2 : curve.y[last];
      return { button, at: value === null ? view.top : clamp(py(value), view.top, view.top + view.height) };
    }).sort((one, other) => one.at - other.at);
    let least = view.top + ENTRY_PX / 2, most = view.top + view.height - ENTRY_PX / 2;
    for (const each of placed) { each.at = max(each.at, least); least = each.at + ENTRY_PX; }
    for (const each of placed.reverse()) { each.at = min(each.at, most); most = each.at - ENTRY_PX; }
    for (const { button, at } of placed) {
      button.style.top = `${100 * at / height}%`;
      button.style.left = `${100 * (view.left + view.width + 4) / full}%`;
    }
  }

  let lastWidth = 0;
  const observer = new ResizeObserver(() => {
    if (figure.clientWidth === lastWidth || !figure.clientWidth) return;
    lastWidth = figure.clientWidth;
    // Later, because a figure that changes its height while it is observed is reported as an error.
    requestAnimationFrame(draw);
  });
  // A chart in a closed list is drawn when the list opens.
  if (!figure.closest("details:not([open])")) {
    lastWidth = figure.clientWidth;
    draw();
  }
  observer.observe(figure);
  // For tests: pixels of values, and the range of the axes.
  const made = {
    figure, data, showTime, redraw,
    pixel: (x, y) => [px(x), py(y)],
    get range() { return [view.x, view.y]; },
    get isLog() { return [isLogX, isLogY]; },
  };
  charts.push(made);
  return () => { observer.disconnect(); charts = charts.filter((other) => other !== made); };
}

// A metric over a swept key: a curve per group of other coordinates.
function sweepData(sweep, metric, key) {
  const { keys, points, runs } = sweep, groups = new Map();
  const hasWords = points.some((place) => typeof place[key] === "string");
  const words = hasWords ? [...new Set(points.map((place) => String(place[key])))] : undefined;
  points.forEach((place, i) => {
    if (place[key] === null || metric.y[i] === null) return;
    const others = keys.map(({ name, unit }, k) => k === key || place[k] === null ? "" : name === "variant" ? place[k] : withUnit(`${name} = ${place[k]}`, typeof place[k] === "number" && unit));
    const name = others.filter(Boolean).join(", ");
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push({ i, x: words ? words.indexOf(String(place[key])) : place[key] });
  });
  const curves = [];
  [...groups].slice(0, MOST_CURVES).forEach(([name, group], color) => {
    group.sort((a, b) => a.x - b.x);
    const of = (column) => group.map(({ i }) => column.length ? column[i] : null), x = group.map((each) => each.x);
    curves.push({ name: name || "measured", style: "data", color, x, y: of(metric.y), e: of(metric.e), runs: of(runs) });
    if (of(metric.t).some((value) => value !== null))
      curves.push({ name: name ? `${name}: theory` : "theory", style: "theory", color, x, y: of(metric.t), e: [] });
  });
  const isSteep = (values) => min(...values) > 0 && max(...values) > 30 * min(...values);
  const isLog = (of) => isSteep(curves.flatMap(of).filter((value) => value !== null));
  return {
    title: `${metric.name} against ${keys[key].name}`, equal: false, time: false, curves,
    remark: groups.size > MOST_CURVES && `the first ${MOST_CURVES} of ${groups.size} curves`,
    x: { label: keys[key].name, unit: keys[key].unit, words, log: !words && isLog((curve) => curve.x) },
    y: { label: metric.name, unit: metric.unit, log: isLog((curve) => curve.y) },
  };
}

for (const source of document.querySelectorAll("script.chart")) chart(source.parentElement, JSON.parse(source.textContent));
const any = document.querySelector(".any");
if (any) {
  const sweep = JSON.parse(any.querySelector("script.sweep").textContent), figure = any.querySelector("figure");
  const metric = any.querySelector(".metric"), key = any.querySelector(".key");
  let remove = () => {};
  const show = () => {
    remove();
    remove = chart(figure, sweepData(sweep, sweep.metrics[metric.selectedIndex], key.selectedIndex));
  };
  any.hidden = false;
  on(metric, "change", show);
  on(key, "change", show);
  show();
}

// Text of pictures is enlarged on a phone.
const condensePictures = () => document.querySelectorAll(".picture text").forEach((text) => condense(text, 610));
condensePictures();
on(document, "toggle", condensePictures, true);
document.querySelector(".hint")?.removeAttribute("hidden");
on(document, "replaytime", () => charts.forEach((each) => each.showTime()));
// On paper, there are two plots in a row, lists of plots and numbers are open, and a strip of pictures stands for the replay.
let opened = [];
on(window, "beforeprint", () => {
  isPrinted = true;
  opened = [...document.querySelectorAll("details.printed:not([open])")];
  opened.forEach((list) => { list.open = true; });
  charts.forEach((each) => each.redraw());
  self.makeStrip?.();
});
on(window, "afterprint", () => {
  isPrinted = false;
  opened.forEach((list) => { list.open = false; });
  charts.forEach((each) => each.redraw());
  document.querySelector(".strip")?.remove();
});

// A link to a definition opens the list that contains it.
function reveal() {
  const target = document.getElementById(location.hash.slice(1)), list = target?.closest("details");
  if (!list || list.open) return;
  list.open = true;
  target.scrollIntoView();
}
on(window, "hashchange", reveal);
reveal();
