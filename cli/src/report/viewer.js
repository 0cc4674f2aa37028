// The slider between the reference and a method. Without this script the page has
// every picture all the same.
(() => {
  const viewer = document.getElementById("viewer");
  const reference = document.querySelector("#reference img");
  const pairs = [...document.querySelectorAll("figure.pair")];
  if (!viewer || !reference || pairs.length === 0) return;
  const names = ["method", "difference", "stage", "canvas", "before", "after", "divider", "slider", "name"];
  const part = Object.fromEntries(
    names.map((name) => [name, viewer.querySelector("[data-part=" + name + "]")]),
  );
  const zooms = [...viewer.querySelectorAll("[data-zoom]")];

  for (const [index, pair] of pairs.entries()) {
    const isFirst = "first" in pair.dataset;
    part.method.add(new Option(pair.dataset.name, index, isFirst, isFirst));
    for (const [place, image] of pair.querySelectorAll("img").entries()) {
      image.addEventListener("click", () => {
        part.method.value = index;
        part.difference.checked = place === 1;
        choose();
        viewer.scrollIntoView({ block: "nearest" });
      });
    }
  }

  function choose() {
    const pair = pairs[part.method.value];
    const images = pair.querySelectorAll("img");
    part.after.src = images[part.difference.checked ? 1 : 0].src;
    part.after.alt = images[part.difference.checked ? 1 : 0].alt;
    part.name.textContent = (part.difference.checked ? "difference of " : "") + pair.dataset.name + " →";
  }

  // The slider runs along what is seen of the picture, zoomed in or not.
  function divide() {
    const { scrollLeft, clientWidth } = part.stage;
    const x = scrollLeft + (part.slider.value / 1000) * clientWidth;
    part.after.style.clipPath = "inset(0 0 0 " + x + "px)";
    part.divider.style.left = x + "px";
  }

  function zoom(factor) {
    const { stage, canvas } = part;
    const before = canvas.clientWidth / stage.clientWidth;
    const centre = (offset, size) => ((offset + size / 2) / before) * factor - size / 2;
    const left = centre(stage.scrollLeft, stage.clientWidth);
    const top = centre(stage.scrollTop, stage.clientHeight);
    canvas.style.width = 100 * factor + "%";
    stage.scrollTo(left, top);
    for (const button of zooms) button.setAttribute("aria-pressed", button.dataset.zoom == factor);
    divide();
  }

  function drag(event) {
    if (event.pointerType !== "mouse" || event.buttons !== 1) return;
    const { left, width } = part.stage.getBoundingClientRect();
    part.slider.value = (1000 * (event.clientX - left)) / width;
    divide();
    event.preventDefault();
  }

  part.before.src = reference.src;
  part.method.addEventListener("change", choose);
  part.difference.addEventListener("change", choose);
  part.slider.addEventListener("input", divide);
  part.stage.addEventListener("scroll", divide);
  part.stage.addEventListener("pointerdown", drag);
  part.stage.addEventListener("pointermove", drag);
  for (const button of zooms) button.addEventListener("click", () => zoom(Number(button.dataset.zoom)));
  addEventListener("resize", divide);
  viewer.hidden = false;
  choose();
  divide();
})();
