// Parts of a picture: scale bar, arrows, texts, stamps, and the rotating frame.
// A bar of a round length with its unit, in a foot below the picture, where nothing else is drawn.
const FOOT = 18;
function drawScale(context, pixelsPer, lengthUnit) {
  const { width, height } = context.canvas, most = width / pixelsPer / 5, unit = 10 ** exponentOf(most);
  const length = [5, 2, 1].find((factor) => factor * unit <= most * (1 + 1e-9)) * unit, tick = 4 * devicePixelRatio;
  const [x, y] = [2 * tick, height - 2 * tick], end = x + length * pixelsPer;
  context.strokeStyle = context.fillStyle = "#e0e0e0";
  context.lineWidth = 1.5 * devicePixelRatio;
  context.beginPath();
  for (const place of [[x, y - tick], [x, y], [end, y], [end, y - tick]]) context.lineTo(...place);
  context.stroke();
  context.textAlign = "left";
  context.fillText(withUnit(number(length, 0, 1), lengthUnit), end + tick, y - tick / 2);
}

// Velocities; that of the top of the color scale has a length of a twentieth of the picture.
function drawArrows(context, film, [vx, vy], base, [across, down]) {
  const { width, height } = context.canvas, length = max(width, height) / 20 / (scale.top || film.speedMax || 1);
  context.strokeStyle = "#ffffff";
  context.lineWidth = devicePixelRatio;
  context.beginPath();
  for (let i = 0; i < film.particles; i++) {
    if (!(across[i] >= -1e6) || vx[base + i] === ABSENT) continue;
    const [u, v] = [vx, vy].map((values) => (values[base + i] * film.velocityStep - film.velocityTop) * length), size = Math.hypot(u, v);
    if (!(size > 1)) continue;
    const [x, y] = [across[i] + u, down[i] - v], head = min(size / 3, 5 * devicePixelRatio) / size, [a, b] = [u * head, -v * head];
    context.moveTo(across[i], down[i]);
    context.lineTo(x, y);
    context.moveTo(x - a - b / 2, y - b + a / 2);
    context.lineTo(x, y);
    context.lineTo(x - a + b / 2, y - b - a / 2);
  }
  context.stroke();
}

// Contact forces; a line of the full width is the largest force of a typical frame.
function drawForces(context, film, frame, [x0, y0, x1, y1, forces], px, py, widest) {
  const count = film.forceLines, from = frame * count;
  context.strokeStyle = "#c81414";
  for (let i = from; i < from + count; i++) {
    if (x0[i] === ABSENT || x1[i] === ABSENT) continue;
    context.lineWidth = min(1, forces[i] / 255 * film.forceTop / scale.force) * widest;
    context.beginPath();
    context.moveTo(px(x0[i]), py(y0[i]));
    context.lineTo(px(x1[i]), py(y1[i]));
    context.stroke();
  }
}

// Writes texts at their places, or below texts and bodies that are there already. A border in the color of the ground keeps lines off them.
function writer(context, bodies) {
  const written = bodies.map(([x, y]) => [x, x, y]), row = 13 * devicePixelRatio;
  return (text, align, x, y) => {
    const width = context.measureText(text).width, left = align === "center" ? x - width / 2 : align === "right" ? x - width : x;
    while (written.some(([a, b, c]) => left < b + row / 2 && a < left + width + row / 2 && Math.abs(c - y) < row)) y += row;
    written.push([left, left + width, y]);
    context.textAlign = align;
    context.lineJoin = "round";
    context.lineWidth = 4 * devicePixelRatio;
    context.strokeStyle = GROUND;
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  };
}

// In the frame that rotates with the planet about the Sun, the particles 1 and 0, both stay where they are: a place in pixels.
function turned([x, y], [sunX, sunY], planet, [left, top]) {
  const [a, b] = [planet[0] - sunX, planet[1] - sunY], size = Math.hypot(a, b), [u, v] = [x - sunX, y - sunY];
  return [left + (a * u + b * v) / size, top + (a * v - b * u) / size];
}

// The box of a bed at rest with a margin, within the whole view; null if it moves.
function boxOfBed(film, data, frame, radiusOf) {
  const count = film.particles, box = [Infinity, Infinity, -Infinity, -Infinity];
  let speeds = 0;
  for (let i = 0; i < count; i++) {
    const place = frame * count + i;
    if (data.xs[place] === ABSENT) continue;
    speeds += (data.speeds[place] / 254) ** 2 * film.speedMax;
    [data.xs, data.ys].forEach((values, axis) => {
      const at = film.origin[axis] + values[place] * film.step;
      box[axis] = min(box[axis], at - radiusOf(i));
      box[axis + 2] = max(box[axis + 2], at + radiusOf(i));
    });
  }
  const margin = 0.08 * max(box[2] - box[0], box[3] - box[1]);
  const grown = box.map((side, k) => k < 2 ? max(side - margin, film.view[k]) : min(side + margin, film.view[k]));
  return grown.every(Number.isFinite) && speeds < AT_REST * count * film.speedTop ? grown : null;
}

// A path of discs, given by their places and radii in pixels.
function discs(context, all) {
  context.beginPath();
  for (const [x, y, radius] of all) {
    context.moveTo(x + radius, y);
    context.arc(x, y, radius, 0, 2 * Math.PI);
  }
}

// Where the view cuts a wall, its end is ragged.
function tear(context, x, y, isUpright) {
  const size = 4 * devicePixelRatio;
  for (let tooth = -2; tooth <= 2; tooth++) {
    const [aside, along] = [size * (tooth % 2 ? 1 : -1) / 2, size * tooth];
    context[tooth > -2 ? "lineTo" : "moveTo"](...(isUpright ? [x + aside, y + along] : [x + along, y + aside]));
  }
}

// A disc as a list of offsets and of covered quarters; radius and place are in quarters of a pixel.
function stampOf(radius, across, down, width) {
  const reach = Math.ceil(radius / 4 + 1), isOutlined = radius >= 4 * OUTLINE_FROM_PX, stamp = [];
  for (let y = -reach; y <= reach; y++) for (let x = -reach; x <= reach; x++) {
    const beyond = Math.hypot(x + 0.5 - across / 4, y + 0.5 - down / 4) - radius / 4 + (isOutlined ? 0.5 : 0);
    const cover = Math.round(4 * clamp(0.5 - beyond, 0, 1));
    if (cover || (isOutlined && beyond < 1)) stamp.push(y * width + x, isOutlined || cover === 4 ? cover : cover - 8);
  }
  return Int32Array.from(stamp);
}

// How much time of the run a second of the playback shows; none if its frames are not evenly spaced.
function scaleOfTime(film, times, factor) {
  const last = film.frames - 1, middle = last >> 1, mean = (times[last] - times[0]) / last;
  if (!(last > 1) || Math.abs((times[middle] - times[0]) / middle / mean - 1) > 0.02) return "";
  const passed = mean * film.fps * factor, thousands = film.units[2] === "s" ? clamp(Math.ceil(-Math.log10(passed) / 3), 0, 3) : 0;
  return ` · each second shows ${withUnit(number(passed * 1000 ** thousands, 0, 2), thousands ? ["ms", "µs", "ns"][thousands - 1] : film.units[2])}`;
}
