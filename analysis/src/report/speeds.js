// The distribution of the speeds in the frame that is shown, with that of Maxwell in two dimensions for the same mean square.
const speedsFigure = document.querySelector(".speeds-now"), BINS = 24, SPEEDS_HEIGHT = 170, FEWEST_SPEEDS = 100;

function drawSpeeds() {
  const svg = speedsFigure.querySelector("svg"), speeds = window.replay?.film && scale.top > 0 ? replay.speeds() : [];
  const total = speeds.reduce((sum, [, count]) => sum + count, 0);
  // Of two runs, it would not show which one it is of.
  speedsFigure.hidden = total < FEWEST_SPEEDS || players().length > 1;
  if (speedsFigure.hidden) return;
  // One unit is one pixel, so that the text keeps its size in a narrow column.
  const width = Math.round(svg.clientWidth) || 480, height = SPEEDS_HEIGHT, [left, right, foot] = [8, width - 8, height - 20], most = 1.25 * scale.top, meanSquare = speeds.reduce((sum, [v, count]) => sum + count * v * v, 0) / total;
  // Densities in units in which the top of Maxwell's is 1.
  const unit = Math.sqrt(2 / Math.E / meanSquare), maxwell = (v) => 2 * v / meanSquare * Math.exp(-v * v / meanSquare) / unit;
  const across = (v) => left + v / most * (right - left), down = (density) => clamp(foot - density / 1.6 * (foot - 4), 0, foot).toFixed(1);
  const counts = new Array(BINS).fill(0);
  for (const [v, count] of speeds) if (v < most) counts[Math.floor(v / most * BINS)] += count;
  let bars = `M${left} ${foot}`, curve = "";
  counts.forEach((count, bin) => { bars += `V${down(count / total / (most / BINS) / unit)}H${across((bin + 1) / BINS * most).toFixed(1)}`; });
  for (let step = 0; step <= 60; step++) curve += `${step ? "L" : "M"}${across(step / 60 * most).toFixed(1)} ${down(maxwell(step / 60 * most))}`;
  const paths = [`${bars}V${foot}Z`, curve];
  // The axis stays as long as the scale and the width do.
  if (svg.dataset.axis === `${most} ${width}`) return paths.forEach((d, i) => svg.children[i].setAttribute("d", d));
  svg.dataset.axis = `${most} ${width}`;
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.replaceChildren();
  element("path", { class: "curve area", style: "stroke:var(--c2);color:var(--c2)", d: paths[0] }, svg);
  element("path", { class: "curve", style: "stroke:var(--c1)", d: paths[1] }, svg);
  element("line", { class: "frame", x1: left, x2: right, y1: foot, y2: foot }, svg);
  for (const { at, text } of ticksOf({}, false, 0, most, 5).ticks) element("text", { x: clamp(across(at), 12, right - 20), y: height - 4, "text-anchor": "middle" }, svg, text);
}
if (speedsFigure && deck) on(window, "resize", drawSpeeds);
if (speedsFigure && deck) for (const name of ["replaytime", "filmchange"]) on(document, name, drawSpeeds);
