// Paths of the first particles up to now, where they are known.
function drawTrails(context, film, data, at, [px, py], center) {
  const count = film.particles, { xs, ys } = data, last = Math.floor(at);
  context.strokeStyle = "#56b4e9";
  context.lineWidth = 1.5 * devicePixelRatio;
  context.beginPath();
  if (center) turnTrails(context, film, data, at, [px, py], center);
  else for (let i = 0; i < min(count, TRAILS); i++) {
    let isDown = false;
    for (let from = 0; from <= last && from < film.frames - 1; from++) {
      const slopes = film.paths[i][from], place = from * count + i, part = from === last ? at - last : 1;
      if (!slopes) { isDown = false; continue; }
      if (!part) break;
      if (!isDown) context.moveTo(px(xs[place]), py(ys[place]));
      isDown = true;
      const [x0, y0, x1, y1] = [xs[place], ys[place], xs[place + count], ys[place + count]];
      // The control points of the cubic's part.
      const [a, b, c, d] = slopes, third = part / 3;
      const [x, y] = [hermite(x0, x1, a, c, part), hermite(y0, y1, b, d, part)];
      const [u, v] = [hermiteSlope(x0, x1, a, c, part), hermiteSlope(y0, y1, b, d, part)];
      context.bezierCurveTo(px(x0 + third * a), py(y0 + third * b), px(x - third * u), py(y - third * v), px(x), py(y));
    }
  }
  context.stroke();
}

// Paths in the frame that rotates about a center, as chords of parts between frames.
function turnTrails(context, film, { xs, ys }, at, [px, py], center) {
  const last = Math.floor(at);
  const placeAt = (i, from, part) => {
    const slopes = film.paths[i][from], place = from * film.particles + i, next = place + film.particles;
    if (!slopes) return null;
    const [a, b, c, d] = slopes;
    return [px(hermite(xs[place], xs[next], a, c, part)), py(hermite(ys[place], ys[next], b, d, part))];
  };
  for (let i = 1; i < min(film.particles, TRAILS); i++) {
    let isDown = false;
    for (let from = 0; from <= last && from < film.frames - 1; from++) for (let k = 0; k <= PARTS; k++) {
      const part = k / PARTS * (from === last ? at - last : 1), [place, sun, planet] = [i, 0, 1].map((body) => placeAt(body, from, part));
      if (place && sun && planet) context[isDown ? "lineTo" : "moveTo"](...turned(place, sun, planet, center));
      isDown = Boolean(place && sun && planet);
    }
  }
}

// The displacements per frame at both ends of each part of the first particles' paths; null where the path is not known.
const pathsOf = (film, data) => Array.from({ length: min(film.particles, TRAILS) }, (_, i) => Array.from({ length: film.frames - 1 }, (_, from) => {
  const slopes = [], kind = motionOf(film, data, from, i, slopes, 0), place = from * film.particles + i;
  if (!isPathKnown(film, data, from, i, kind, slopes[4])) return null;
  const [across, up] = [data.xs, data.ys].map((values) => values[place + film.particles] - values[place]);
  return kind === LINE ? [across, up, across, up] : slopes;
}));
