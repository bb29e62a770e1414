// The flights of discs between frames, in the layout of analysis/src/replay/encoding.rs. Only pages with recorded collisions contain this.
// For each interval between frames and particle: where its corners begin in the lists of times and places, and how many there are.
function flightsOf({ particles, flights: [corners, intervals] }, series) {
  const counts = series(intervals, particles, 1), [times, xs, ys] = [0, 1, 2].map(() => series(corners, 1, 1)), starts = new Uint32Array(counts.length);
  let next = 0;
  for (let i = 0; i < particles; i++) for (let place = i; place < counts.length; place += particles) {
    starts[place] = next;
    next += counts[place];
  }
  return { counts, starts, times, xs, ys };
}

// The stored place of a particle on its flight between two corners, at a part of the way from a frame to the next; `place` beyond the known intervals.
function flown(film, { xs, ys, times }, frame, i, part, place) {
  const from = frame * film.particles + i, to = from + film.particles, { counts, starts, ...corners } = times.flights;
  if (!(from < counts.length && xs[from] !== ABSENT && xs[to] !== ABSENT)) return place;
  let next = starts[from], start = [0, xs[from], ys[from]], end = [1, xs[to], ys[to]];
  for (const last = next + counts[from]; next < last; next++) {
    const corner = [corners.times[next] / (ABSENT - 1), corners.xs[next], corners.ys[next]];
    if (corner[0] > part) { end = corner; break; }
    start = corner;
  }
  const share = (part - start[0]) / (end[0] - start[0]), rise = film.flights[2] * (times[frame + 1] - times[frame]) ** 2 * (part - start[0]) * (end[0] - part);
  return [start[1] + share * (end[1] - start[1]), start[2] + share * (end[2] - start[2]) + rise];
}
