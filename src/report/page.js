// The script of Sundog's reports. Everything can be read without it; it adds values under the pointer, the bar between
// pictures, sorting and the choice between light and dark.
"use strict";

document.documentElement.classList.add("js");
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/** A new element with a class and with text as text. */
function element(name, className = "", text = "") {
  const made = document.createElement(name);
  if (className) made.className = className;
  made.textContent = text;
  return made;
}

/** Four digits, as the rest of the page has them. */
function words(value, unit) {
  if (Number.isNaN(value)) return "not finite";
  const size = Math.abs(value);
  const plain = size === 0 || (size >= 1e-4 && size < 1e7);
  const text = plain ? String(Number(value.toPrecision(4))) : value.toExponential(3).replace("e+", "e");
  return unit ? `${text} ${unit}` : text;
}

// --- light and dark -------------------------------------------------------------------------------------------------

/** Keeps the choice where the browser allows it (for local files some do not). */
const kept = {
  get() { try { return localStorage.getItem("sundog-theme"); } catch { return null; } },
  set(theme) { try { localStorage.setItem("sundog-theme", theme); } catch { /* then it holds for this page */ } },
};

function setUpTheme(button) {
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const now = () => root.dataset.theme ?? (system.matches ? "dark" : "light");
  const show = () => {
    const other = now() === "dark" ? "Light" : "Dark";
    button.textContent = other;
    button.setAttribute("aria-label", `${other} colours`);
  };
  const before = kept.get();
  if (before === "light" || before === "dark") root.dataset.theme = before;
  button.hidden = false;
  button.addEventListener("click", () => {
    root.dataset.theme = now() === "dark" ? "light" : "dark";
    kept.set(root.dataset.theme);
    show();
  });
  system.addEventListener("change", show);
  show();
}

// --- tables ---------------------------------------------------------------------------------------------------------

function setUpSorting(table) {
  const heads = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  const key = (row, column) => {
    const cell = row.cells[column];
    const value = cell?.dataset.value;
    return value === undefined ? cell?.textContent ?? "" : Number(value);
  };
  const compare = (a, b) => {
    const [numberA, numberB] = [typeof a === "number", typeof b === "number"];
    if (numberA && numberB) return a - b;
    if (numberA !== numberB) return numberA ? -1 : 1;
    return a.localeCompare(b, "en", { numeric: true });
  };
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const rows = [...body.rows].map((row) => ({ row, key: key(row, column) }));
      rows.sort((a, b) => {
        // What is not a number stands last either way.
        const [noneA, noneB] = [Number.isNaN(a.key), Number.isNaN(b.key)];
        if (noneA || noneB) return noneA - noneB;
        return down ? compare(b.key, a.key) : compare(a.key, b.key);
      });
      body.append(...rows.map(({ row }) => row));
    });
  });
}

// --- plots ----------------------------------------------------------------------------------------------------------

function setUpPlot(figure) {
  const stage = figure.querySelector(".stage");
  const spoken = figure.querySelector(".spoken");
  const data = JSON.parse(figure.querySelector("script").textContent);
  const curves = data.series.filter((series) => series.points.length > 0);
  if (curves.length === 0) return;
  const ring = element("span", "ring");
  const tip = element("div", "tip");
  ring.hidden = tip.hidden = true;
  stage.append(ring, tip);
  let chosen = null;

  /** Where the frame of the plot that is shown lies, in pixels of the stage. */
  function frame() {
    const holder = [...stage.querySelectorAll("[data-frame]")].find((each) => each.offsetParent !== null);
    const [left, top, right, bottom] = holder.dataset.frame.split(" ").map(Number);
    const box = holder.getBoundingClientRect();
    return {
      x: (share) => box.width * (left + share * (right - left)),
      y: (share) => box.height * (bottom - share * (bottom - top)),
    };
  }

  const nearestInX = (series, x) =>
    series.points.reduce((best, point) => Math.abs(point.at[0] - x) < Math.abs(best.at[0] - x) ? point : best);

  /** What a curve has at x: a point that is there, else the line between its neighbours, else nothing. */
  function at(series, x) {
    const near = nearestInX(series, x);
    if (Math.abs(near.at[0] - x) < 0.004) return { x: near.x, y: near.spread ? `${near.y} (${near.spread})` : near.y };
    for (let index = 1; series.line && index < series.points.length; index++) {
      const [a, b] = [series.points[index - 1].at, series.points[index].at];
      if (Math.min(a[0], b[0]) <= x && x <= Math.max(a[0], b[0])) {
        const share = a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
        const value = data.y.low + share * (data.y.high - data.y.low);
        return { x: "", y: `≈ ${words(data.y.log ? 10 ** value : value, data.y.unit)}` };
      }
    }
    return { x: "", y: "–" };
  }

  /** A row of the tip for each curve: the chosen point, and what the others have at the same x. */
  function fill(curve, point) {
    tip.replaceChildren();
    const table = element("table");
    const head = table.createTHead().insertRow();
    ["", data.x.label, data.y.label].forEach((text) => head.append(element("th", "", text)));
    const body = table.createTBody();
    for (const series of curves) {
      const own = series === curve;
      const shown = own ? { x: point.x, y: point.spread ? `${point.y} (${point.spread})` : point.y } : at(series, point.at[0]);
      const row = body.insertRow();
      if (own) row.className = "chosen";
      const name = element("th", `dot curve-${series.color}`);
      name.append(element("span", "", series.name));
      row.append(name, element("td", "", shown.x), element("td", "", shown.y));
    }
    if (point.label) tip.append(element("div", "label", point.label));
    tip.append(table);
    const spread = point.spread ? `, ${point.spread}` : "";
    spoken.textContent = `${curve.name}${point.label ? `, ${point.label}` : ""}: ${data.x.label} ${point.x}, ${data.y.label} ${point.y}${spread}`;
  }

  function choose(curve, point) {
    const changed = chosen?.point !== point;
    chosen = { curve, point };
    const { x, y } = frame();
    const [left, top] = [x(point.at[0]), y(point.at[1])];
    ring.className = `ring curve-${curve.color}`;
    ring.hidden = tip.hidden = false;
    if (changed) fill(curve, point);
    ring.style.left = `${left}px`;
    ring.style.top = `${top}px`;
    // Beside the point, on the side with room, never outside of the stage.
    const room = stage.clientWidth;
    const beside = left + 18 + tip.offsetWidth <= room ? left + 18 : left - 18 - tip.offsetWidth;
    tip.style.left = `${clamp(beside, 0, Math.max(0, room - tip.offsetWidth))}px`;
    const below = beside >= 0 ? top - tip.offsetHeight / 2 : top + 18;
    tip.style.top = `${Math.max(0, below)}px`;
  }

  function clear() {
    chosen = null;
    ring.hidden = tip.hidden = true;
    spoken.textContent = "";
  }

  function chooseNearest(event) {
    const box = stage.getBoundingClientRect();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    const { x, y } = frame();
    let best = null;
    for (const curve of curves) {
      for (const point of curve.points) {
        const distance = Math.hypot(x(point.at[0]) - px, y(point.at[1]) - py);
        if (!best || distance < best.distance) best = { curve, point, distance };
      }
    }
    choose(best.curve, best.point);
  }

  function step(event) {
    if (event.key === "Escape") return clear();
    const keys = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End"];
    if (!keys.includes(event.key) || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    if (!chosen) return choose(curves[0], curves[0].points[0]);
    let { curve, point } = chosen;
    const index = curve.points.indexOf(point);
    const last = curve.points.length - 1;
    const turn = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (turn) {
      curve = curves[(curves.indexOf(curve) + turn + curves.length) % curves.length];
      point = nearestInX(curve, point.at[0]);
    } else {
      const next = { ArrowLeft: index - 1, ArrowRight: index + 1, Home: 0, End: last }[event.key];
      point = curve.points[clamp(next, 0, last)];
    }
    choose(curve, point);
  }

  stage.addEventListener("pointermove", chooseNearest);
  stage.addEventListener("pointerdown", chooseNearest);
  stage.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse" && document.activeElement !== stage) clear(); });
  stage.addEventListener("keydown", step);
  stage.addEventListener("focus", () => { if (stage.matches(":focus-visible") && !chosen) choose(curves[0], curves[0].points[0]); });
  stage.addEventListener("blur", clear);
  new ResizeObserver(() => { if (chosen) choose(chosen.curve, chosen.point); }).observe(stage);
}

// --- before and after -----------------------------------------------------------------------------------------------

function setUpSlider(slider) {
  const stage = slider.querySelector(".stage");
  const holder = slider.querySelector(".pictures");
  const pictures = [...holder.querySelectorAll("figure")];
  const bar = slider.querySelector(".bar");
  const place = slider.querySelector("input");
  const [left, right, zoom] = [".left-choice", ".right-choice", ".zoom"].map((name) => slider.querySelector(name));
  if (pictures.length === 0) return;

  function show() {
    const at = Number(place.value);
    pictures.forEach((picture, index) => {
      const [isLeft, isRight] = [index === Number(left.value), index === Number(right.value)];
      picture.classList.toggle("on", isLeft || isRight);
      const clip = isLeft && isRight ? "none" : isLeft ? `inset(0 ${100 - at}% 0 0)` : `inset(0 0 0 ${at}%)`;
      picture.firstElementChild.style.clipPath = clip;
    });
    bar.style.left = `${at}%`;
    const names = [left, right].map((choice) => choice.selectedOptions[0]?.textContent ?? "");
    place.setAttribute("aria-valuetext", `${Math.round(at)} % ${names[0]}, ${Math.round(100 - at)} % ${names[1]}`);
  }

  /** The picture's size: all of it in sight and never enlarged, or whole pixels of the screen for each of its own. */
  function resize() {
    const factor = Number(zoom.value);
    const [width, height] = ["width", "height"].map((name) => Number(pictures[0].firstElementChild.getAttribute(name)));
    const fitting = Math.min(width, slider.clientWidth, 0.85 * innerHeight * width / height);
    holder.classList.toggle("zoomed", factor > 0);
    holder.style.width = `${factor > 0 ? width * factor / devicePixelRatio : fitting}px`;
    place.style.width = `${stage.clientWidth}px`;
  }

  function drag(event) {
    const box = holder.getBoundingClientRect();
    place.value = 100 * clamp((event.clientX - box.left) / box.width, 0, 1);
    show();
  }

  holder.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    holder.setPointerCapture(event.pointerId);
    drag(event);
    place.focus({ preventScroll: true });
    event.preventDefault();
  });
  holder.addEventListener("pointermove", (event) => { if (holder.hasPointerCapture(event.pointerId)) drag(event); });
  place.addEventListener("input", show);
  left.addEventListener("change", show);
  right.addEventListener("change", show);
  zoom.addEventListener("change", resize);
  addEventListener("resize", resize);
  resize();
  show();
}

// --- heat maps ------------------------------------------------------------------------------------------------------

/** The numbers of a heat map: see heat_map.rs for how they are stored. */
async function decode(data, count) {
  const packed = Uint8Array.from(atob(data.codes), (symbol) => symbol.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const codes = new Uint16Array(count);
  let code = 0;
  for (let index = 0; index < count; index++) {
    code = (code + 256 * bytes[index] + bytes[count + index]) & 0xffff;
    codes[index] = code;
  }
  return codes;
}

function valueOf(code, data) {
  if (code === 0xffff) return NaN;
  if (code === 0) return 0;
  const value = data.low + (code - 1) / 65533 * (data.high - data.low);
  return data.log ? 10 ** value : value;
}

function setUpHeatMap(figure) {
  const stage = figure.querySelector(".stage");
  const picture = stage.querySelector("img");
  const cross = stage.querySelector(".cross");
  const readout = figure.querySelector(".readout");
  const data = JSON.parse(figure.querySelector("script").textContent);
  const [width, height] = ["width", "height"].map((name) => Number(picture.getAttribute(name)));
  let codes = null;
  let at = null;

  async function choose(x, y) {
    at = [clamp(x, 0, width - 1), clamp(y, 0, height - 1)];
    codes ??= decode(data, width * height);
    cross.hidden = false;
    const [column, row] = at;
    cross.style.left = `${(column + 0.5) / width * picture.clientWidth}px`;
    cross.style.top = `${(row + 0.5) / height * picture.clientHeight}px`;
    const code = (await codes)[row * width + column];
    // The pointer may have gone on while the numbers were unpacked.
    if (at[0] === column && at[1] === row) {
      readout.textContent = `${words(valueOf(code, data), data.unit)} at ${column}, ${row}`;
    }
  }

  function point(event) {
    const box = picture.getBoundingClientRect();
    choose(Math.floor((event.clientX - box.left) / box.width * width), Math.floor((event.clientY - box.top) / box.height * height));
  }

  function step(event) {
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const move = moves[event.key];
    if (!move || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const stride = event.shiftKey ? 16 : 1;
    const [x, y] = at ?? [width >> 1, height >> 1];
    choose(x + stride * move[0], y + stride * move[1]);
  }

  stage.addEventListener("pointermove", point);
  stage.addEventListener("pointerdown", point);
  stage.addEventListener("keydown", step);
  stage.addEventListener("focus", () => { if (!at && stage.matches(":focus-visible")) choose(width >> 1, height >> 1); });
  new ResizeObserver(() => { if (at) choose(...at); }).observe(stage);
}

setUpTheme(document.getElementById("theme"));
document.querySelectorAll("table.sortable").forEach(setUpSorting);
document.querySelectorAll(".plot").forEach(setUpPlot);
document.querySelectorAll(".slider").forEach(setUpSlider);
document.querySelectorAll(".map").forEach(setUpHeatMap);
