// Shows the experiments of a model whose text contains all words.
"use strict";
const [words, model] = ["words", "model"].map((name) => document.querySelector(`[name="${name}"]`));
const found = document.querySelector(".found");
function filter() {
  const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const group of document.querySelectorAll(".shelf")) {
    let shown = 0;
    for (const card of group.querySelectorAll(".cards > li")) {
      const text = card.textContent.toLowerCase();
      card.hidden = (model.value && model.value !== group.dataset.model) || !wanted.every((word) => text.includes(word));
      if (!card.hidden) shown++;
    }
    group.hidden = !shown;
    count += shown;
  }
  found.textContent = count ? "" : "No experiment contains these words.";
}
document.querySelector(".filter").hidden = false;
words.addEventListener("input", filter);
model.addEventListener("change", filter);
filter();
