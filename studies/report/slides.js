"use strict";
(() => {
  const data = JSON.parse(document.getElementById("slides").textContent);
  const last = data.labels.length - 1, radius = data.edges[data.edges.length - 1];
  const slider = document.getElementById("state"), play = document.getElementById("play");
  const box = { left: 66, right: 448, top: 10, bottom: 218 };

  const make = (parent, name, attributes, text) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    parent.appendChild(node);
    return node;
  };
  // numbers of up to three digits: 0.25, 2·10⁻⁵
  const written = (value) => {
    if (value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5)) return String(value);
    const [mantissa, exponent] = value.toExponential().split("e");
    return `${mantissa}·10${[...exponent.replace("+", "")].map((sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]).join("")}`;
  };
  const ticks = (top, bottom = 0) => {
    const raw = (top - bottom) / 4, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((factor) => factor * power >= raw) * power;
    const first = Math.ceil(bottom / step - 1e-9), count = Math.floor(top / step + 1e-9) - first + 1;
    return Array.from({ length: count }, (_, index) => +((first + index) * step).toPrecision(3));
  };
  // the axis begins at the edge of a wide hole
  const hole = data.edges[0] > radius / 2 ? data.edges[0] : 0;
  const across = (r) => box.left + ((r - hole) / (radius - hole)) * (box.right - box.left);
  const rings = data.ring;
  // numbers that are unknown or infinite are null
  const known = (value) => value !== null;

  // draw axes once, and scale, curve and reference curve again for each state
  const plot = (id, values, reference, tops, down, label) => {
    const svg = document.getElementById(id);
    let top = 1;
    const upright = (value) => {
      const share = Math.max(-9, Math.min(9, value / top));
      return down ? box.top + share * (box.bottom - box.top) : box.bottom - share * (box.bottom - box.top);
    };
    data.shade.forEach((shade, ring) => {
      const x = across(data.edges[ring]), width = across(data.edges[ring + 1]) - x;
      if (shade > 0.5) make(svg, "rect", { x, width, y: box.top, height: box.bottom - box.top, fill: "#e8e8e8" });
    });
    for (const tick of ticks(radius, hole)) {
      make(svg, "line", { x1: across(tick), x2: across(tick), y1: box.bottom, y2: box.bottom + 4, stroke: "#1b1f24" });
      make(svg, "text", { x: across(tick), y: box.bottom + 17, "text-anchor": "middle" }, written(tick));
    }
    const frame = { x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top };
    make(svg, "rect", { ...frame, fill: "none", stroke: "#1b1f24" });
    make(svg, "text", { x: (box.left + box.right) / 2, y: 254, "text-anchor": "middle" }, data.axes.radius);
    const middle = (box.top + box.bottom) / 2;
    make(svg, "text", { x: 12, y: middle, "text-anchor": "middle", transform: `rotate(-90 12 ${middle})` }, label);
    const line = (row) => row.map((value, index) => {
      if (!known(value)) return "";
      // pressures jump at the edges of rings
      const begins = index === 0 || !known(row[index - 1]) || (!down && rings[index] !== rings[index - 1]);
      return `${begins ? "M" : "L"}${across(data.radii[index]).toFixed(1)},${upright(value).toFixed(1)}`;
    }).join("");
    const clip = make(make(svg, "clipPath", { id: `within-${id}` }), "rect", { ...frame });
    clip.setAttribute("y", box.top - 2);
    const look = { fill: "none", "stroke-linejoin": "round", "clip-path": `url(#within-${id})` };
    const scaled = make(svg, "g", {});
    const ghost = make(svg, "path", { ...look, stroke: "#777", "stroke-dasharray": "2 3" });
    const curve = make(svg, "path", { ...look, stroke: "#1f4e79", "stroke-width": 2 });
    return (state) => {
      top = tops[state];
      scaled.replaceChildren();
      for (const tick of ticks(top)) {
        make(scaled, "line", { x1: box.left - 4, x2: box.left, y1: upright(tick), y2: upright(tick), stroke: "#1b1f24" });
        make(scaled, "text", { x: box.left - 7, y: upright(tick) + 4, "text-anchor": "end" }, written(tick));
      }
      if (last > 0) ghost.setAttribute("d", line(reference(state)));
      curve.setAttribute("d", line(values[state]));
    };
  };
  // the same height is subtracted from the unworn face as from the profile
  const unworn = (state) => data.unworn.map((height) => known(height) ? height - data.subtracted[state] : null);
  const drawProfile = plot("profile", data.profile, unworn, data.deepest, true, data.axes.profile);
  const drawPressure = plot("pressure", data.pressure, () => data.pressure[last], data.highest, false, data.axes.pressure);

  // draw the worn face as a surface of revolution that is cut open, from the back to the front
  const canvas = document.getElementById("solid"), pen = canvas.getContext("2d");
  const AROUND = 72, OPEN = 17, TILT = 0.62, DEPTH = 0.32;
  const drawnRadii = [];
  let lastDrawn = -1;
  data.radii.forEach((r, index) => {
    if (index === 0 || index === data.radii.length - 1 || r - lastDrawn > radius / 110 || rings[index] !== rings[index - 1]) {
      drawnRadii.push(index);
      lastDrawn = r;
    }
  });
  let turn = 0.5;
  const colour = (shade, light) => {
    const mix = (a, b) => Math.round((a + (b - a) * shade) * light);
    return `rgb(${mix(96, 224)},${mix(120, 208)},${mix(146, 170)})`;
  };
  const drawSolid = (state) => {
    const heights = data.profile[state], height = (index) => -data.drawn * Math.min(1, heights[index] / data.solid);
    const sin = Math.sin(TILT), cos = Math.cos(TILT), size = canvas.width * 0.34;
    const place = (r, angle, z) => {
      const x = r / radius * Math.cos(angle + turn), y = r / radius * Math.sin(angle + turn);
      const down = canvas.height * 0.37 - size * (z * cos + y * sin);
      return [canvas.width / 2 + size * x, down, y * cos - z * sin];
    };
    const faces = [];
    const face = (corners, fill) => faces.push([corners.reduce((sum, corner) => sum + corner[2], 0), corners, fill]);
    const angle = (step) => (step + OPEN) * 2 * Math.PI / AROUND - Math.PI;
    for (let strip = 0; strip + 1 < drawnRadii.length; strip += 1) {
      const inner = drawnRadii[strip], outer = drawnRadii[strip + 1], a = data.radii[inner], b = data.radii[outer];
      if (!known(heights[inner]) || !known(heights[outer])) continue;
      const shade = data.shade[rings[inner]], slope = (height(outer) - height(inner)) / Math.max((b - a) / radius, 1e-9);
      for (let step = 0; step < AROUND - OPEN; step += 1) {
        const start = angle(step), stop = angle(step + 1), middle = (start + stop) / 2 + turn;
        const light = (1 - slope * (0.35 * Math.cos(middle) - 0.5 * Math.sin(middle))) / Math.hypot(1, slope) * 0.9;
        const corners = [place(a, start, height(inner)), place(b, start, height(outer)),
          place(b, stop, height(outer)), place(a, stop, height(inner))];
        face(corners, colour(shade, Math.max(0.35, Math.min(1.1, light))));
      }
      for (const cut of [angle(0), angle(AROUND - OPEN)]) {
        const corners = [place(a, cut, height(inner)), place(b, cut, height(outer)), place(b, cut, -DEPTH - data.drawn),
          place(a, cut, -DEPTH - data.drawn)];
        face(corners, colour(shade, 0.72));
      }
    }
    const end = drawnRadii[drawnRadii.length - 1];
    for (let step = 0; step < AROUND - OPEN; step += 1) {
      const start = angle(step), stop = angle(step + 1), foot = -DEPTH - data.drawn;
      const corners = [place(radius, start, height(end)), place(radius, stop, height(end)), place(radius, stop, foot),
        place(radius, start, foot)];
      face(corners, colour(data.shade[data.shade.length - 1], 0.55 + 0.15 * Math.cos((start + stop) / 2 + turn)));
    }
    faces.sort((first, second) => second[0] - first[0]);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.lineWidth = 0.8;
    for (const [, corners, fill] of faces) {
      pen.beginPath();
      corners.forEach(([x, y], index) => (index ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.closePath();
      pen.fillStyle = pen.strokeStyle = fill;
      pen.fill();
      pen.stroke();
    }
  };

  let shown = last;
  const show = (state) => {
    shown = state;
    document.getElementById("when").textContent = data.labels[state];
    if (slider) slider.value = state;
    drawProfile(state);
    drawPressure(state);
    drawSolid(state);
  };
  if (slider) {
    let timer = 0;
    const stop = () => { clearInterval(timer); timer = 0; play.textContent = "Play"; };
    slider.addEventListener("input", () => { stop(); show(+slider.value); });
    play.addEventListener("click", () => {
      if (timer) return stop();
      play.textContent = "Stop";
      let next = shown === last ? 0 : shown;
      timer = setInterval(() => { show(next); next += 1; if (next > last) stop(); }, 120);
      return undefined;
    });
  }
  let from = null;
  canvas.addEventListener("pointerdown", (event) => { from = event.clientX; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointermove", (event) => {
    if (from === null) return;
    turn += (event.clientX - from) / 150;
    from = event.clientX;
    drawSolid(shown);
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { from = null; });
  show(last);
})();
