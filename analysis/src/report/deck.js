// The players together: their arrangement, their common scales, their controls, and their pictures on paper.
// The players that are displayed: of the first run, of the second one, and on request of others.
const find = (selector) => deck.querySelector(selector), MOST_PLAYERS = 6;
let others = [];
const players = () => [window.replay, window.replay?.second, ...others].filter((each) => each?.film && !each.part.hidden);

// Players are in the number of rows that shows their runs largest. The first ones are complete on the screen.
function arrange() {
  const all = players(), count = all.length;
  if (!count) return;
  const isFull = document.fullscreenElement === deck, width = deck.clientWidth;
  const above = isFull ? 0 : all[0].canvas.getBoundingClientRect().top + scrollY;
  const below = innerHeight - above - (isFull ? 150 : 90), room = min(900, below > 0.45 * innerHeight ? below : 0.7 * innerHeight);
  const shape = max(...all.map((each) => each.shape()));
  const columns = (rows) => Math.ceil(count / rows), size = (rows) => min(width / columns(rows), (room / rows - (rows > 1 && 30)) / shape);
  let rows = 1;
  for (let more = 2; more <= count; more++) if (size(more) > size(rows)) rows = more;
  const box = find(".players");
  box.style.setProperty("--columns", columns(rows));
  box.classList.toggle("dense", columns(rows) > 2);
  all.forEach((each) => each.resize(room / rows - (rows > 1 && 20)));
}

// Players of further runs, at even distances among those that are not shown.
function addPlayers(second) {
  const shown = players().map(({ file }) => file), rest = films.flatMap(({ dataset: { film, file } }, index) => film && !shown.includes(file) ? [index] : []);
  const length = min(rest.length, MOST_PLAYERS - shown.length);
  return Array.from({ length }, (_, i) => {
    const part = second.cloneNode(true), name = `run ${i + 3}`;
    part.querySelector("span").textContent = `R${name.slice(1)}: `;
    part.querySelector("canvas").ariaLabel = `Particles of ${name}`;
    part.querySelector(".runs").selectedIndex = rest[Math.floor(i * rest.length / length)];
    second.parentElement.append(part);
    return player(part, replay);
  });
}

// The region that contains all views, or null if the smallest of them would hardly be visible in it.
const MOST_ENLARGED = 4;
function common(views) {
  const side = ([x0, y0, x1, y1]) => max(x1 - x0, y1 - y0), sides = views.map(side);
  const all = [0, 1, 2, 3].map((k) => (k < 2 ? min : max)(...views.map((view) => view[k])));
  return side(all) <= MOST_ENLARGED * min(...sides) ? all : null;
}

// One color scale, and if possible one scale of lengths, for all runs that are displayed.
function share() {
  const all = players();
  const widest = all.reduce((found, each) => each.film.speedTop > (found?.speedTop ?? -1) ? each.film : found, null);
  if (!widest) return;
  const fastest = max(...all.map((each) => each.film.speedMax)), isSpeed = scale.by === "speed";
  scale.top = widest.speedTop;
  scale.force = max(...all.map((each) => each.film.forceTop));
  scale.spin = max(...all.map((each) => each.film.spinTop));
  find('[value="spin"]').hidden = !scale.spin;
  find(".bar").style.background = `linear-gradient(to right, ${widest.colors.join()})`;
  find(".scale").hidden = isSpeed && !(scale.top > 0);
  const [low, high] = { height: ["low at start", "high"], side: ["left at start", "right"], species: ["first species", "last"], spin: ["clockwise", `counterclockwise, ${number(scale.spin, 0, 3)} rad/${widest.units[2]}`] }[scale.by] ?? ["speed 0",
    `${fastest > 1.005 * scale.top ? "≥ " : ""}${withUnit(widest.speedTopText, widest.units[1])}`];
  find(".bottom").textContent = low;
  find(".top").textContent = high;
  const latest = max(...all.map((each) => each.end));
  all.forEach((each) => each.outlast(latest));
  const whole = common(all.map((each) => each.film.view)), first = common(all.map((each) => each.firstView()));
  all.forEach((each) => each.agree(whole ? first ?? whole : each.film.view, whole ?? each.film.view));
  for (const [name, can] of [["arrows", all.some((each) => each.canHaveArrows())], ["rotating", all.some((each) => each.canRotate())], ["forces", all.some((each) => each.film.forceLines)]])
    find(`.${name}`).parentElement.hidden = !can;
}

if (deck) {
  deck.hidden = false;
  const [first, second] = deck.querySelectorAll(".player"), box = find(".pair"), many = find(".many"), colors = find(".colors");
  if (typeof DecompressionStream === "undefined") {
    deck.querySelectorAll(".stage, .controls, .readout").forEach((part) => { part.hidden = true; });
    find(".note").textContent = "This browser cannot play the replay: it has no DecompressionStream.";
  } else {
    const refresh = () => { share(); arrange(); };
    on(document, "filmchange", refresh);
    on(window, "resize", arrange);
    on(document, "fullscreenchange", arrange);
    window.replay = player(first);
    // A second run next to the first one, with its clock.
    if (second) replay.second = player(second, replay);
    for (const each of [box, many]) if (each) on(each, "change", () => {
      if (many && each === box) many.checked &&= box.checked;
      else box.checked ||= each.checked;
      second.hidden = !box.checked;
      if (many?.checked && !others.length) others = addPlayers(second);
      others.forEach(({ part }) => { part.hidden = !many.checked; });
      refresh();
    });
    const color = () => {
      scale.by = colors.value;
      share();
    };
    on(colors, "change", color);
    const switches = ["arrows", "rotating", "forces"].map((name) => find(`.${name}`));
    const draw = () => {
      [scale.hasArrows, scale.isRotating, scale.hasForces] = switches.map((each) => each.checked);
      color();
    };
    for (const each of switches) on(each, "change", draw);
    draw();
    const full = find(".full");
    full.hidden = !deck.requestFullscreen;
    on(full, "click", () => document.fullscreenElement ? document.exitFullscreen() : deck.requestFullscreen());
  }
}

// On paper, the replay is a strip of five pictures.
const STRIP = 5;
function makeStrip() {
  const [first] = players();
  if (!first || first.frames < 2) return;
  const strip = element("div", { class: "strip" }, deck);
  for (let picture = 0; picture < STRIP; picture++) {
    const [copy, time] = first.pictureAt(picture * (first.frames - 1) / (STRIP - 1), 360), figure = element("figure", {}, strip);
    figure.append(copy);
    element("figcaption", {}, figure, time);
  }
}
