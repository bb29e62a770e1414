// The players together: their arrangement, their common scales, their controls, and their pictures on paper.
// The players that are displayed.
const players = () => [window.replay, window.replay?.second].filter((each) => each?.film && !each.part.hidden);

// Players are next to each other or one above the other, whichever shows their runs larger. The first ones are complete on the screen.
function arrange() {
  const all = players(), box = deck.querySelector(".players");
  if (!all.length) return;
  const isFull = document.fullscreenElement === deck, width = deck.clientWidth;
  const above = isFull ? 0 : all[0].canvas.getBoundingClientRect().top + scrollY;
  const below = innerHeight - above - (isFull ? 150 : 90), room = min(900, below > 0.45 * innerHeight ? below : 0.7 * innerHeight);
  const shape = max(...all.map((each) => each.shape()));
  const isStacked = all.length > 1 && min(width, (room / 2 - 30) / shape) > min(width / 2, room / shape);
  box.classList.toggle("stacked", isStacked);
  all.forEach((each) => each.resize(isStacked ? room / 2 - 20 : room));
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
  deck.querySelector(".bar").style.background = `linear-gradient(to right, ${widest.colors.join()})`;
  deck.querySelector(".scale").hidden = isSpeed && !(scale.top > 0);
  const [low, high] = { height: ["low at start", "high"], side: ["left at start", "right"], species: ["first species", "last"] }[scale.by] ?? ["speed 0",
    `${fastest > 1.005 * scale.top ? "≥ " : ""}${withUnit(widest.speedTopText, widest.units[1])}`];
  deck.querySelector(".bottom").textContent = low;
  deck.querySelector(".top").textContent = high;
  const latest = max(...all.map((each) => each.end));
  all.forEach((each) => each.outlast(latest));
  const whole = common(all.map((each) => each.film.view)), first = common(all.map((each) => each.firstView()));
  all.forEach((each) => each.agree(whole ? first ?? whole : each.film.view, whole ?? each.film.view));
  for (const [name, can] of [["arrows", all.some((each) => each.canHaveArrows())], ["rotating", all.some((each) => each.canRotate())]])
    deck.querySelector(`.${name}`).parentElement.hidden = !can;
}

if (deck) {
  deck.hidden = false;
  const [first, second] = deck.querySelectorAll(".player"), box = deck.querySelector(".pair"), colors = deck.querySelector(".colors");
  if (typeof DecompressionStream === "undefined") {
    deck.querySelectorAll(".stage, .controls, .readout").forEach((part) => { part.hidden = true; });
    deck.querySelector(".note").textContent = "This browser cannot play the replay: it has no DecompressionStream.";
  } else {
    const refresh = () => { share(); arrange(); };
    on(document, "filmchange", refresh);
    on(window, "resize", arrange);
    on(document, "fullscreenchange", arrange);
    window.replay = player(first);
    // A second run next to the first one, with its clock.
    if (second) replay.second = player(second, replay);
    if (box) on(box, "change", () => {
      second.hidden = !box.checked;
      refresh();
    });
    const color = () => {
      scale.by = colors.value;
      share();
    };
    on(colors, "change", color);
    const [arrows, rotating] = ["arrows", "rotating"].map((name) => deck.querySelector(`.${name}`));
    const draw = () => {
      [scale.hasArrows, scale.isRotating] = [arrows.checked, rotating.checked];
      color();
    };
    for (const each of [arrows, rotating]) on(each, "change", draw);
    draw();
    const full = deck.querySelector(".full");
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
