// The film of a run: its numbers, its colors, and how particles move between its frames.
const films = [...document.querySelectorAll("script.film")], decodedFilms = new Map();

// The numbers of a film, in the layout of analysis/src/replay/encoding.rs: raw DEFLATE in base64.
async function decoded(film, text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const { frames, particles, wallPoints } = film;
  const times = new Float64Array(bytes.buffer, 0, frames), numbers = new Uint32Array(bytes.buffer, 8 * frames, frames);
  let at = 12 * frames;
  const series = (count, width, order) => {
    const values = new Uint16Array(count * width), length = values.length;
    for (let i = 0; i < length; i++) {
      const zigzag = bytes[at + i] | (bytes[at + length + i] << 8);
      values[i] = (zigzag >> 1) ^ -(zigzag & 1);
    }
    at += 2 * length;
    for (let pass = 0; pass < order; pass++) for (let i = width; i < length; i++) values[i] += values[i - width];
    return values;
  };
  const radii = series(film.growing ? frames : 1, particles, 1);
  const [xs, ys] = film.orders.map((order) => series(frames, particles, order));
  const speeds = bytes.slice(at, at += frames * particles);
  for (let i = particles; i < speeds.length; i++) speeds[i] += speeds[i - particles];
  const wallFrames = film.movingWalls ? frames : 1;
  const walls = [series(wallFrames, wallPoints, 2), series(wallFrames, wallPoints, 2)];
  const styles = series(wallFrames, wallPoints / 2, 1);
  const velocities = film.velocityStep ? [series(frames, particles, 1), series(frames, particles, 1)] : [];
  const spins = film.spinTop ? bytes.slice(at, at += frames * particles) : [];
  for (let i = particles; i < spins.length; i++) spins[i] += spins[i - particles];
  const forces = Array.from({ length: film.forceLines && 5 }, () => series(frames, film.forceLines, 1));
  if (film.flights) times.flights = flightsOf(film, series); // flights
  return { times, numbers, radii, xs, ys, speeds, walls, styles, velocities, spins, forces };
}

const ABSENT = 65535, ABSENT_SPEED = 255, STEPS = 64, OUTLINE_FROM_PX = 6, PAINTED_FROM = 1500, GROUND = "#101418", TRAILS = 8, PARTS = 3, FEWEST_IN_BED = 50, AT_REST = 0.05, LEAST_LEAD = 0.01;
const rgb = (color) => [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16));

// Colors from rest to the top speed, then that of an unknown speed, and that of the Sun.
function palette(stops) {
  const colors = stops.map(rgb);
  const mixed = Array.from({ length: STEPS }, (_, step) => {
    const place = step / (STEPS - 1) * (colors.length - 1), low = min(Math.floor(place), colors.length - 2);
    return colors[low].map((part, i) => Math.round(part + (place - low) * (colors[low + 1][i] - part)));
  });
  return [...mixed, [154, 154, 154], [240, 200, 60]];
}
const UNKNOWN = STEPS, SUN = STEPS + 1;

// Opaque pixels of each color over the ground, in quarters.
const shadesOf = (colors) => Uint32Array.from(colors.flatMap((color) => [0, 1, 2, 3, 4].map((quarters) => {
  const [r, g, b] = rgb(GROUND).map((part, i) => Math.round(part + quarters / 4 * (color[i] - part)));
  return (255 << 24 | b << 16 | g << 8 | r) >>> 0;
})));

// Between two frames, a particle is on a cubic that has its positions and velocities at both (Hermite). Where these contradict each other, because of a
// contact or an event, it moves along a line; where it could not have moved so far, as at a periodic border, it stays until half of the time.
const STAYS = 0, LINE = 1, CURVE = 2;

// The kind of the motion after a frame. For a curve, the displacements per frame at both ends, in stored steps, and an estimate of its error are put into
// five places of a list.
function motionOf(film, { xs, ys, times, velocities }, frame, i, list, place) {
  const at = frame * film.particles + i, next = at + film.particles;
  if (xs[at] === ABSENT || xs[next] === ABSENT) return STAYS;
  const across = xs[next] - xs[at], up = ys[next] - ys[at], far = Math.hypot(across, up);
  const vx = velocities[0], vy = velocities[1];
  if (!vx || vx[at] === ABSENT || vx[next] === ABSENT) return far > film.longest / 4 ? STAYS : LINE;
  const perFrame = (times[frame + 1] - times[frame]) / film.step, size = film.velocityStep * perFrame, zero = film.velocityTop * perFrame;
  const a = vx[at] * size - zero, b = vy[at] * size - zero, c = vx[next] * size - zero, d = vy[next] * size - zero;
  const length = Math.sqrt(max(a * a + b * b, c * c + d * d)), rounding = 2 + size;
  // On a curve of the angle a, the mean of the velocities misses the displacement by a^2/12 of it, and the cubic misses the curve by a^3/384.
  const miss = max(0, Math.hypot(across - (a + c) / 2, up - (b + d) / 2) - rounding);
  // A turn by more than a right angle may be a bounce, which has the same ends as a throw.
  if (a * c + b * d >= 0 && miss <= MOST_MISSED * length) {
    list[place] = a;
    list[place + 1] = b;
    list[place + 2] = c;
    list[place + 3] = d;
    list[place + 4] = length * (12 * miss / length) ** 1.5 / 384 || 0;
    return CURVE;
  }
  return far > 2 * length + rounding && far > film.longest / 4 ? STAYS : LINE;
}
const MOST_MISSED = 0.17;

// The cubic of two places and slopes at a fraction of the frame, and its slope there.
const hermite = (from, to, first, last, part) =>
  from + part * (first + part * (3 * (to - from) - 2 * first - last + part * (2 * (from - to) + first + last)));
const hermiteSlope = (from, to, first, last, part) =>
  first + part * (2 * (3 * (to - from) - 2 * first - last) + 3 * part * (2 * (from - to) + first + last));

// Whether the path after a frame is known within 1/400 of the view: by velocities, or because it turns by at most 30 degrees from frame to frame.
function isPathKnown(film, data, frame, i, kind, error) {
  if (kind === CURVE) return error <= film.longest / 400;
  if (kind === STAYS || data.velocities.length) return false;
  const at = frame * film.particles + i, { xs, ys } = data;
  const turn = (middle) => {
    const [before, after] = [middle - film.particles, middle + film.particles];
    if (!(xs[before] !== ABSENT && xs[after] !== ABSENT && before >= 0 && after < xs.length)) return 0;
    const [ax, ay, bx, by] = [xs[middle] - xs[before], ys[middle] - ys[before], xs[after] - xs[middle], ys[after] - ys[middle]];
    return Math.abs(Math.atan2(ax * by - ay * bx, ax * bx + ay * by));
  };
  return max(turn(at), turn(at + film.particles)) <= Math.PI / 6;
}

// The time at a place in the film, in frames; beyond the last frame, frames go on at the last distance.
function timeAt({ times }, place) {
  const last = times.length - 1, low = clamp(Math.floor(place), 0, max(0, last - 1)), high = min(low + 1, last);
  return times[low] + (place - low) * (times[high] - times[low]);
}

// The place of a time in the film.
function placeOf({ times }, time) {
  const last = times.length - 1;
  let low = 0;
  while (low < last - 1 && times[low + 1] <= time) low++;
  const length = times[min(low + 1, last)] - times[low];
  return length > 0 ? max(0, low + (time - times[low]) / length) : low;
}
