// The distribution of the speeds or of the heights in the frame that is shown, with its law.
const live = document.querySelector(".live"), BINS = 24, TALL = 190, FEWEST = 100;

// Speeds in percent of the particles per bar, with Maxwell's distribution in two dimensions for the same mean square at fractions of the range.
function speedsNow() {
  const speeds = replay.speeds(), total = speeds.reduce((sum, [, n]) => sum + n, 0);
  const rms = Math.sqrt(speeds.reduce((sum, [v, n]) => sum + n * v * v, 0) / total);
  // The range is halved as often as the speeds of the run are in this frame: by Maxwell's distribution, 1 of 100 is above 2.15 times their root mean square.
  const halvings = max(0, Math.floor(Math.log2(scale.top / 2.15 / rms))), most = 1.25 * scale.top / 2 ** halvings;
  // Low speeds have few stored values: bars are wide enough for some of them.
  const bins = halvings > 2 ? BINS / 2 : BINS, bar = 100 * most / bins, counts = new Array(bins).fill(0);
  for (const [v, n] of speeds) if (v < most) counts[Math.floor(v / most * bins)] += n;
  const law = Array.from({ length: 61 }, (_, step) => [step / 60, bar * 2 / rms * (step / 60 * most / rms) * Math.exp(-((step / 60 * most / rms) ** 2))]);
  // Maxwell's distribution is at most sqrt(2/e) over the root mean square, of which this is 1.6 times as much.
  return { total, range: [0, most], top: 1.37 * bar / rms, bars: counts.map((n) => 100 * n / total), law, words: "particles (%)" };
}

// Densities over their mean in layers of a round container, with the barometric law.
function heightsNow({ range, areas, law }) {
  const counts = areas.map(() => 0), all = replay.positions();
  for (const [, , y] of all) counts[clamp(Math.floor((y - range[0]) / (range[1] - range[0]) * areas.length), 0, areas.length - 1)]++;
  const over = (values) => values.map((value, i) => value / areas[i]), expected = over(law);
  return {
    total: all.length, range, top: 1.25 * max(...expected), bars: over(counts).map((density) => density / all.length),
    law: expected.map((density, i) => [(i + 0.5) / areas.length, density]), words: "density / mean",
  };
}

function drawLive() {
  const svg = live.querySelector("svg"), layers = live.dataset.layers;
  const found = window.replay?.film && (layers ? heightsNow(JSON.parse(layers)) : scale.top > 0 && speedsNow());
  // Of two runs, it would not show which one it is of.
  live.hidden = !(found?.total >= FEWEST) || players().length > 1;
  if (live.hidden) return;
  // One unit is one pixel, so that the text keeps its size in a narrow column.
  const { range: [low, high], top, bars, law, words } = found, width = Math.round(svg.clientWidth) || 480, [left, right, foot] = [52, width - 16, TALL - 38];
  const across = (part) => (left + part * (right - left)).toFixed(1), down = (density) => clamp(foot - density / top * (foot - 4), 0, foot).toFixed(1);
  const paths = [
    `M${left} ${foot}${bars.map((density, bin) => `V${down(density)}H${across((bin + 1) / bars.length)}`).join("")}V${foot}Z`,
    law.map(([part, density], i) => `${i ? "L" : "M"}${across(part)} ${down(density)}`).join(""),
  ];
  // The axes stay as long as the ranges and the width do.
  const axes = `${low} ${high} ${top.toPrecision(3)} ${width}`;
  if (svg.dataset.axes === axes) return paths.forEach((d, i) => svg.children[i].setAttribute("d", d));
  svg.dataset.axes = axes;
  svg.setAttribute("viewBox", `0 0 ${width} ${TALL}`);
  svg.replaceChildren();
  element("path", { class: "curve area", style: "stroke:var(--c2);color:var(--c2)", d: paths[0] }, svg);
  element("path", { class: "curve", style: "stroke:var(--c1)", d: paths[1] }, svg);
  element("path", { class: "frame", d: `M${left} 4V${foot}H${right}` }, svg);
  const text = (x, y, anchor, words) => element("text", { x, y, "text-anchor": anchor }, svg, words);
  for (const { at, text: words } of ticksOf({}, false, low, high, 5).ticks) text(across((at - low) / (high - low)), foot + 16, "middle", words);
  for (const { at, text: words } of ticksOf({}, false, 0, top, 3).ticks) text(left - 6, clamp(down(at) - -4, 12, foot), "end", words);
  text((left + right) / 2, TALL - 5, "middle", live.dataset.axis);
  element("text", { transform: `translate(14 ${foot / 2}) rotate(-90)`, "text-anchor": "middle" }, svg, words);
}
if (live && deck) for (const [target, name] of [[window, "resize"], [document, "replaytime"], [document, "filmchange"]]) on(target, name, drawLive);
