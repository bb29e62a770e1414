// The distribution of the speeds or of the heights in the frame that is shown, with its law.
const live = document.querySelector(".live"), BINS = 24, LIVE_HEIGHT = 170, FEWEST_COUNTED = 100;

// Speeds, with Maxwell's distribution in two dimensions for the same mean square, in units in which its top is 1: the density in each bin, and the law at
// fractions of the range.
function speedsNow() {
  const speeds = replay.speeds(), total = speeds.reduce((sum, [, count]) => sum + count, 0), most = 1.25 * scale.top;
  const meanSquare = speeds.reduce((sum, [v, count]) => sum + count * v * v, 0) / total, unit = Math.sqrt(2 / Math.E / meanSquare);
  const counts = new Array(BINS).fill(0);
  for (const [v, count] of speeds) if (v < most) counts[Math.floor(v / most * BINS)] += count;
  const law = Array.from({ length: 61 }, (_, step) => [step / 60, 2 * step / 60 * most / meanSquare * Math.exp(-((step / 60 * most) ** 2) / meanSquare) / unit]);
  return { total, range: [0, most], top: 1.6, bars: counts.map((count) => count / total / (most / BINS) / unit), law };
}

// Densities over their mean in layers of a round container, with the barometric law.
function heightsNow({ range, areas, law }) {
  const counts = areas.map(() => 0), all = replay.positions();
  for (const [, , y] of all) counts[clamp(Math.floor((y - range[0]) / (range[1] - range[0]) * areas.length), 0, areas.length - 1)]++;
  const over = (values) => values.map((value, i) => value / areas[i]), expected = over(law);
  return {
    total: all.length, range, top: 1.25 * max(...expected), bars: over(counts).map((density) => density / all.length),
    law: expected.map((density, i) => [(i + 0.5) / areas.length, density]),
  };
}

function drawLive() {
  const svg = live.querySelector("svg"), layers = live.dataset.layers;
  const found = window.replay?.film && (layers ? heightsNow(JSON.parse(layers)) : scale.top > 0 && speedsNow());
  // Of two runs, it would not show which one it is of.
  live.hidden = !(found?.total >= FEWEST_COUNTED) || players().length > 1;
  if (live.hidden) return;
  // One unit is one pixel, so that the text keeps its size in a narrow column.
  const width = Math.round(svg.clientWidth) || 480, [left, right, foot] = [8, width - 8, LIVE_HEIGHT - 20], { range: [low, high], top, bars, law } = found;
  const across = (part) => (left + part * (right - left)).toFixed(1), down = (density) => clamp(foot - density / top * (foot - 4), 0, foot).toFixed(1);
  const paths = [
    `M${left} ${foot}${bars.map((density, bin) => `V${down(density)}H${across((bin + 1) / bars.length)}`).join("")}V${foot}Z`,
    law.map(([part, density], i) => `${i ? "L" : "M"}${across(part)} ${down(density)}`).join(""),
  ];
  // The axis stays as long as the range and the width do.
  const axis = `${low} ${high} ${width}`;
  if (svg.dataset.axis === axis) return paths.forEach((d, i) => svg.children[i].setAttribute("d", d));
  svg.dataset.axis = axis;
  svg.setAttribute("viewBox", `0 0 ${width} ${LIVE_HEIGHT}`);
  svg.replaceChildren();
  element("path", { class: "curve area", style: "stroke:var(--c2);color:var(--c2)", d: paths[0] }, svg);
  element("path", { class: "curve", style: "stroke:var(--c1)", d: paths[1] }, svg);
  element("line", { class: "frame", x1: left, x2: right, y1: foot, y2: foot }, svg);
  for (const { at, text } of ticksOf({}, false, low, high, 5).ticks) {
    const half = widthOf(text, TEXT_PX) / 2 + 1;
    element("text", { x: clamp(across((at - low) / (high - low)), half, width - half), y: LIVE_HEIGHT - 4, "text-anchor": "middle" }, svg, text);
  }
}
if (live && deck) for (const [target, name] of [[window, "resize"], [document, "replaytime"], [document, "filmchange"]]) on(target, name, drawLive);
