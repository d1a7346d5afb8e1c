"use strict";
(() => {
  const body = document.body;
  const sections = [...document.querySelectorAll("section")];
  const set = (what, value) => {
    body.dataset[what] = value;
    document.querySelectorAll(`button[data-${what}]`).forEach(b => b.setAttribute("aria-pressed", b.dataset[what] === value));
    if (what === "zoom") document.querySelectorAll("img").forEach(size);
  };
  const size = image => {
    const factor = Number(body.dataset.zoom);
    image.style.width = factor > 0 && image.naturalWidth ? `${image.naturalWidth * factor}px` : "";
  };
  document.querySelectorAll("button[data-view]").forEach(b => b.addEventListener("click", () => set("view", b.dataset.view)));
  document.querySelectorAll("button[data-zoom]").forEach(b => b.addEventListener("click", () => set("zoom", b.dataset.zoom)));
  document.querySelectorAll("img").forEach(i => i.addEventListener("load", () => size(i)));
  sections.forEach(section => {
    const range = section.querySelector("input");
    if (!range) return;
    const cut = percent => {
      range.value = percent;
      section.style.setProperty("--cut", `${percent}%`);
    };
    range.addEventListener("input", () => cut(range.value));
    section.querySelectorAll(".pair img").forEach(image => image.addEventListener("pointermove", e => {
      if (body.dataset.view !== "slider") return;
      const box = image.getBoundingClientRect();
      cut(Math.max(0, Math.min(100, (e.clientX - box.left) / box.width * 100)));
    }));
  });
  const go = step => {
    const at = sections.findIndex(s => s.getBoundingClientRect().bottom > 150);
    const to = sections[Math.max(0, Math.min(sections.length - 1, at + step))];
    if (to) { to.scrollIntoView(); to.focus({ preventScroll: true }); }
  };
  const views = ["side", "blink", "slider", "difference"], zooms = ["fit", "1", "2", "4", "8"];
  document.addEventListener("keydown", e => {
    if (e.ctrlKey || e.metaKey || e.altKey || e.target.tagName === "INPUT") return;
    const k = "1234".indexOf(e.key);
    if (k >= 0) set("view", views[k]);
    else if (e.key === "z") set("zoom", zooms[(zooms.indexOf(body.dataset.zoom) + 1) % zooms.length]);
    else if (e.key === "j") go(1);
    else if (e.key === "k") go(-1);
  });
  const wanted = new URLSearchParams(location.search);
  set("view", views.includes(wanted.get("view")) ? wanted.get("view") : "side");
  set("zoom", zooms.includes(wanted.get("zoom")) ? wanted.get("zoom") : "fit");
})();
