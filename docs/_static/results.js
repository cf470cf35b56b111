// Search of claims, filters of tables, moving pictures. Without it everything is shown, at rest.
"use strict";
const fold = (text) => text.toLowerCase().normalize("NFKD");

function searchClaims() {
  const form = document.querySelector("form.search");
  if (!form || !document.getElementById("claim-search")) return;
  const [words, verdict, count] = ["input", "select", "output"].map((tag) => form.querySelector(tag));
  const claims = [...document.querySelectorAll(".claim")];
  const printed = [...document.querySelectorAll(".printed")];
  const texts = claims.map((claim) => fold(claim.closest("section").textContent));
  const isId = (word) => /^[vla]\d+$/.test(word);
  const show = () => {
    const asked = fold(words.value).split(/\s+/).filter(Boolean);
    let shown = 0;
    claims.forEach((claim, k) => {
      const fits = asked.every((word) => (isId(word) ? claim.id.toLowerCase() === word : texts[k].includes(word)))
        && (!verdict.value || claim.dataset.verdicts.split(",").includes(verdict.value));
      claim.closest("section").hidden = !fits;
      if (asked.length) claim.querySelectorAll("details").forEach((part) => { part.open = fits && texts[k].length < 40000; });
      shown += fits;
    });
    printed.forEach((part) => {
      const text = fold(part.textContent);
      const named = [...part.querySelectorAll("a")].map((link) => fold(link.textContent));
      const fits = asked.every((word) => (isId(word) ? named.includes(word) : text.includes(word)));
      part.hidden = Boolean(verdict.value) || !fits;
    });
    // A heading stays where something below it does: first those of parts, then those of documents.
    const holders = [...new Set([...claims, ...printed].flatMap((part) => {
      const section = part.closest("section"), inner = part.matches(".claim") ? section.parentElement : section;
      return [inner, inner.parentElement];
    }))].filter((section) => section && section.matches("section section"));
    holders.forEach((section) => {
      section.hidden = ![...section.querySelectorAll(".claim, .printed")].some((part) => !part.hidden && !(part.matches(".claim") && part.closest("section").hidden));
    });
    count.textContent = `${shown} of ${claims.length} claims`;
  };
  form.hidden = false;
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("input", show);
  // A link to a hidden claim shows all of them again.
  addEventListener("hashchange", () => {
    const target = document.getElementById(location.hash.slice(1));
    if (target && target.closest("[hidden]")) { form.reset(); show(); target.scrollIntoView(); }
  });
  show();
}

function filterTable(form) {
  const table = document.getElementById(form.dataset.table);
  if (!table) return;
  const rows = [...table.tBodies[0].rows], choices = [...form.querySelectorAll("select")];
  const said = form.querySelector("output");
  const show = () => {
    let count = 0;
    rows.forEach((row) => {
      const fits = choices.every((one) => !one.value || row.cells[one.dataset.column].textContent === one.value
        || row.cells[one.dataset.column].textContent.split(", ").includes(one.value));
      row.hidden = !fits;
      count += fits;
    });
    said.textContent = count ? `${count} of ${rows.length} rows` : form.dataset.none;
  };
  form.hidden = false;
  form.addEventListener("input", show);
  show();
}

function play(figure) {
  const dots = [...figure.querySelectorAll(".moving")];
  const paths = dots.map((dot) => JSON.parse(dot.dataset.points));
  const button = figure.querySelector("button");
  const seconds = 40;
  let began = null, done = 0, running = false;
  const draw = (share) => dots.forEach((dot, k) => {
    const at = share * (paths[k].length - 1), low = Math.floor(at), part = at - low;
    const one = paths[k][low], two = paths[k][Math.min(low + 1, paths[k].length - 1)];
    dot.setAttribute("cx", one[0] + part * (two[0] - one[0]));
    dot.setAttribute("cy", one[1] + part * (two[1] - one[1]));
  });
  const frame = (now) => {
    if (!running) return;
    began ??= now - 1000 * seconds * done;
    done = ((now - began) / (1000 * seconds)) % 1;
    draw(done);
    requestAnimationFrame(frame);
  };
  const toggle = (on) => {
    running = on;
    began = null;
    button.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(frame);
  };
  button.hidden = false;
  button.addEventListener("click", () => toggle(!running));
  toggle(!matchMedia("(prefers-reduced-motion: reduce)").matches);
}

searchClaims();
document.querySelectorAll("form.filter").forEach(filterTable);
document.querySelectorAll("figure.motion").forEach(play);
// Print shows what is folded.
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((one) => { one.open = true; }));
