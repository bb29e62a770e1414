// Verify in this browser: the engine repeats the runs in a worker, and the page says whether each frame is that of the recording.
{
  const section = document.querySelector(".engine");
  const [line, list, status] = ["p", "ul", "[role=status]"].map((place) => section.querySelector(place));
  const button = line.querySelector("button");
  const label = button.textContent;
  const claims = [...document.querySelectorAll("script.claim")];
  const name = (run) => (claims.length > 1 ? `${claims[run].dataset.file}: ` : "");
  const seconds = (number) => `${number < 10 ? number.toFixed(1) : number.toFixed(0)} s`;
  let worker, items = [], offered;

  // A text from a page that was changed may be long.
  const set = (item, text, quality) => {
    item.textContent = text.slice(0, 2000);
    item.className = quality;
    if (quality) status.textContent = item.textContent;
  };

  const say = (text, quality = "") => {
    const item = list.appendChild(document.createElement("li"));
    set(item, text, quality);
    return item;
  };

  const stop = (text) => {
    worker?.terminate();
    worker = undefined;
    button.textContent = label;
    offered?.remove();
    if (text) say(text, "bad");
  };

  // The result of a run, or how far it is.
  const result = ({ all, key, frames, difference, fault, error, part, seconds: took }) => {
    if (error) return [error, "bad"];
    const equal = `of the repeated run equal those of the recording (${seconds(took)}; run key ${key?.slice(0, 8)})`;
    if (difference === undefined) return part ? [`the first ${frames} of ${all} frames ${equal}`, "good"] : [`${frames} of ${all} frames are equal so far`, ""];
    if (difference === null) return [`all ${frames} frames ${equal}${fault ? `, and the run fails alike: ${fault}` : ""}`, "good"];
    const { first, last, topics } = difference;
    const where = first === last ? `frame ${first} differs` : `one of the frames ${first} to ${last} differs`;
    const why = fault ? `: the repeated run ended after ${frames} frames (${fault})` : frames <= first || all <= first ? ", because one of the runs has fewer frames" : "";
    return [`${where}${topics.length ? `: ${topics.slice(0, 20).join(", ")}` : why}`, "bad"];
  };

  const offer = ({ run, few, all, expected }) => {
    const item = (offered = say(`${name(run)}the whole run takes about ${seconds(expected)} here: `));
    status.textContent = item.textContent;
    for (const [text, frames] of [[`compare the first ${few} frames`, few], [`compare all ${all}`, all]].slice(few < all ? 0 : 1)) {
      const choice = item.appendChild(document.createElement("button"));
      choice.textContent = text;
      choice.onclick = () => {
        item.remove();
        button.focus();
        worker?.postMessage({ frames });
      };
      item.append(" ");
    }
  };

  const show = ({ data }) => {
    if (data.failed) return stop(data.failed);
    if (data.done) return stop();
    if (data.versions) {
      const [[physics, schema], [own, ownSchema]] = data.versions;
      say(`${name(data.run)}recorded with version ${physics} of the physics and ${schema} of the messages; this engine has ${own} and ${ownSchema}, so that frames may differ`);
    } else if (data.few) {
      offer(data);
    } else {
      const [text, quality] = result(data);
      items[data.run] ??= say("");
      set(items[data.run], name(data.run) + text, quality);
    }
  };

  // The texts that the page shows as the manifest of a run.
  const shown = ({ dataset }, run) => {
    const changeable = JSON.parse(document.querySelector(".rerun script").textContent).runs[run]?.manifest;
    return [...document.querySelectorAll("pre[data-file]")].filter((text) => text.dataset.file === dataset.file).map((text) => text.textContent).concat(changeable ?? []);
  };

  const start = () => {
    list.textContent = "";
    items = [];
    button.textContent = "Stop";
    try {
      worker = self.kinetoscopeWorker(show, stop);
      worker.postMessage({ claims: claims.map((claim) => claim.textContent), shown: claims.map(shown) });
    } catch (error) {
      stop(`the engine cannot be started (${error.message})`);
    }
  };

  line.hidden = false;
  if (self.kinetoscopeLack) {
    button.disabled = true;
    say(self.kinetoscopeLack);
  }
  button.onclick = () => (worker ? stop("stopped") : start());
}
