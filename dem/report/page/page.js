"use strict";
// Boxes switch curves on and off; a point under the pointer, or the slider, chooses the bed that is drawn.
const chart = document.getElementById("drag");
const slider = document.getElementById("slider");
const moved = BEDS.displacement;
const COLORS = BEDS.colors; // those of the figures
document.documentElement.style.setProperty("--shade", COLORS.link);
let shown = Object.keys(BEDS.cases)[0];
let snapshot = 0;

function unpack(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Int16Array(bytes.buffer);
}

function bedOf(name) {
  const bed = BEDS.cases[name];
  if (typeof bed.x === "string") {
    for (const key of ["x", "y", "angle"]) bed[key] = unpack(bed[key]);
  }
  return bed;
}

function outline(pen, rings, size) {
  pen.beginPath();
  for (const ring of rings) {
    for (let k = 0; k < ring.length; k += 2) pen.lineTo(ring[k] * size, ring[k + 1] * size);
    pen.closePath();
  }
  pen.fill();
  pen.stroke();
}

function draw() {
  const bed = bedOf(shown);
  const canvas = document.getElementById("bed");
  const pen = canvas.getContext("2d");
  const highest = Math.max(...bed.height);
  const scale = Math.min((canvas.width - 8) / BEDS.width, (canvas.height - 8) / highest);
  const unit = bed.scale / BEDS.steps;
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.setTransform(scale, 0, 0, -scale, 4, 4 + highest * scale);
  pen.lineWidth = 0.8 / scale;
  pen.strokeStyle = COLORS.outline;
  for (let i = 0; i < bed.granules; i++) {
    const at = snapshot * bed.granules + i;
    const layer = Math.floor(((bed.y[i] * unit) / bed.height[0]) * BEDS.layers);
    pen.save();
    pen.translate(bed.x[at] * unit, bed.y[at] * unit);
    pen.rotate((bed.angle[at] / BEDS.steps) * 2 * Math.PI);
    pen.fillStyle = COLORS.layers[layer % COLORS.layers.length];
    outline(pen, bed.rings, bed.diameter[i]);
    pen.restore();
  }
  pen.fillStyle = COLORS.steel;
  pen.beginPath();
  pen.arc(BEDS.width / 2, bed.axis[snapshot], BEDS.cylinder / 2, 0, 2 * Math.PI);
  pen.fill();
  pen.stroke();
  pen.lineWidth = 2 / scale;
  pen.strokeStyle = "black";
  pen.strokeRect(0, 0, BEDS.width, bed.height[snapshot]);
  document.getElementById("where").textContent = `${shown} after ${moved[snapshot].toFixed(2)} mm${bed.drawn}`;
  document.getElementById("bed").setAttribute("aria-label", `The bed of ${shown} after ${moved[snapshot].toFixed(2)} mm, granules in layers`);
  slider.value = snapshot;
  slider.setAttribute("aria-valuetext", `${moved[snapshot].toFixed(2)} mm`);
}

function nearest(displacement) {
  let best = 0;
  moved.forEach((value, i) => {
    if (Math.abs(value - displacement) < Math.abs(moved[best] - displacement)) best = i;
  });
  return best;
}

function boxes(place, names, checked) {
  for (const name of names) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.value = name;
    box.checked = checked(name);
    box.addEventListener("change", () => { if (box.checked && name in BEDS.cases) { shown = name; draw(); } choose(); });
    label.append(box, ` ${name}`);
    const run = chart.data.find((each) => each.meta[0] === name);
    if (run) label.style.borderBottom = `3px ${run.line.dash === "solid" ? "solid" : "dashed"} ${run.line.color}`;
    document.getElementById(place).append(label);
  }
}

function chosen(place) {
  return new Set([...document.querySelectorAll(`#${place} input:checked`)].map((box) => box.value));
}

function choose() {
  const cases = chosen("choice-case");
  const seeds = chosen("choice-seed");
  const visible = chart.data.map((run) => cases.has(run.meta[0]) && seeds.has(String(run.meta[1])));
  Plotly.restyle(chart, { visible });
  if (!cases.has(shown)) {
    const other = [...cases].find((name) => name in BEDS.cases);
    if (other) { shown = other; draw(); }
  }
}

const unique = (place) => [...new Set(chart.data.map((run) => String(run.meta[place])))];
const on = chart.data.filter((run) => run.visible);
boxes("choice-case", unique(0), (name) => on.some((run) => run.meta[0] === name));
boxes("choice-seed", unique(1), (name) => on.some((run) => String(run.meta[1]) === name));
slider.max = moved.length - 1;
slider.addEventListener("input", () => { snapshot = Number(slider.value); draw(); });
chart.on("plotly_hover", (event) => {
  const point = event.points[0];
  if (point.data.meta[0] in BEDS.cases) shown = point.data.meta[0];
  snapshot = nearest(point.x);
  draw();
});
draw();
