// Two layers that are made only while they are shown: the camera's own picture with what was found
// in it, and the clearance of every place.

const TIGHT = 254;

export class CameraView {
  constructor(stage, connection) {
    Object.assign(this, { stage, connection });
    this.canvas = document.getElementById("camera");
    this.context = this.canvas.getContext("2d", { alpha: false });
    connection.on("camera", (message) => this.#show(message));
  }

  /** Shown in place of the picture from above and of what is drawn over that. */
  set wanted(on) {
    this.canvas.hidden = !on;
    this.stage.element.classList.toggle("shows-camera", on);
    this.connection.watch({ camera: on });
  }

  async #show(message) {
    try {
      const bitmap = await createImageBitmap(new Blob([message.arrays.jpeg], { type: "image/jpeg" }));
      const [width, height] = message.size_px;
      if (this.canvas.width !== bitmap.width) Object.assign(this.canvas, { width: bitmap.width, height: bitmap.height });
      this.context.setTransform(bitmap.width / width, 0, 0, bitmap.height / height, 0, 0);
      this.context.drawImage(bitmap, 0, 0, width, height);
      bitmap.close();
      this.#drawFound(message);
      this.canvas.dataset.number = message.number;
    } finally {
      this.connection.send({ type: "ack", number: message.number });
    }
  }

  #drawFound({ arrays, ids }) {
    const style = getComputedStyle(this.stage.element);
    const colour = (name) => style.getPropertyValue(name);
    const { border, border_first: first, corners } = arrays;
    for (let b = 0; b + 1 < first.length; b++) {
      this.#line(border.subarray(2 * first[b], 2 * first[b + 1]), b ? colour("--goal") : colour("--path"));
    }
    ids.forEach((id, n) => {
      const points = corners.subarray(8 * n, 8 * n + 8);
      this.#line(points, colour("--track"));
      const [x, y] = [(points[0] + points[4]) / 2, Math.max(points[1], points[3], points[5], points[7])];
      this.#label(`marker ${id}`, x, y, colour("--track"), colour("--halo"));
    });
  }

  #line(points, colour) {
    const c = this.context;
    c.beginPath();
    for (let k = 0; k < points.length; k += 2) c.lineTo(points[k] + 0.5, points[k + 1] + 0.5);
    c.closePath();
    for (const [width, ink] of [[4, "rgb(255 255 255 / 0.7)"], [2, colour]]) {
      Object.assign(c, { lineWidth: width, strokeStyle: ink, lineJoin: "round" });
      c.stroke();
    }
  }

  #label(text, x, y, ink, halo) {
    const c = this.context;
    Object.assign(c, { font: "650 15px system-ui, sans-serif", textAlign: "center", lineWidth: 4, strokeStyle: halo, fillStyle: ink, lineJoin: "round" });
    c.strokeText(text, x, y + 20);
    c.fillText(text, x, y + 20);
  }
}

export class Heat {
  #message = null;

  constructor(stage, connection) {
    Object.assign(this, { stage, connection });
    this.canvas = document.getElementById("heat");
    connection.on("heat", (message) => { this.#message = message; this.#draw(); });
  }

  set wanted(on) {
    this.canvas.hidden = !on;
    this.connection.watch({ heat: on });
  }

  #draw() {
    const { columns, rows, arrays } = this.#message;
    Object.assign(this.canvas, { width: columns, height: rows });
    const context = this.canvas.getContext("2d");
    const image = context.createImageData(columns, rows);
    const style = getComputedStyle(this.stage.element);
    const colours = new Map();
    const rgb = (name) => (style.getPropertyValue(name).match(/\d+/g) ?? [0, 0, 0]).slice(0, 3).map(Number);
    arrays.steps.forEach((step, k) => {
      if (step > TIGHT) return; // an obstacle, or outside
      if (!colours.has(step)) colours.set(step, [...rgb(step === TIGHT ? "--obstacle" : `--ramp-${step}`), step === TIGHT ? 120 : 175]);
      image.data.set(colours.get(step), 4 * k);
    });
    context.putImageData(image, 0, 0);
  }
}
