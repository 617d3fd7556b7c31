// The live picture: decoded beside the page's thread, drawn, and only then acknowledged, so that a slow
// page gets fewer pictures and never old ones. The program sends no more pixels than are shown.

const OLD_MS = 1000;
const SETTLED_MS = 200; // a wheel turns through many sizes

export class Picture {
  #context;
  #drawn = 0;
  #age = 0;
  #wanted = true;
  #timer = 0;
  #said = 0;

  constructor(stage, connection) {
    this.stage = stage;
    this.connection = connection;
    this.count = 0;
    this.note = document.getElementById("picture-note");
    this.#context = stage.canvas.getContext("2d", { alpha: false });
    connection.on("picture", (message) => this.#show(message));
    connection.on("camera", (message) => { [this.#drawn, this.#age] = [performance.now(), message.age_ms]; });
    connection.on("state", (state) => this.#watch(state));
    this.#saySize();
    stage.onResize.push(() => {
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => this.#saySize(), SETTLED_MS);
    });
  }

  #saySize() {
    if (this.stage.width_px !== this.#said) this.connection.watch({ width_px: this.#said = this.stage.width_px });
  }

  /** True if the picture is shown; else it is not asked for. */
  set wanted(on) {
    this.#wanted = on;
    this.connection.watch({ on });
  }

  async #show(message) {
    try {
      const bitmap = await createImageBitmap(new Blob([message.arrays.jpeg], { type: "image/jpeg" }));
      const { width, height } = bitmap;
      const { canvas } = this.stage;
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
      this.#context.drawImage(bitmap, 0, 0);
      bitmap.close();
      this.#drawn = performance.now();
      this.#age = message.age_ms;
      this.count += 1;
      canvas.dataset.number = message.number;
    } finally {
      this.connection.send({ type: "ack", number: message.number });
    }
  }

  #watch(state) {
    if (!this.#wanted || state.replay) { // what was recorded is as old as it is
      this.note.hidden = true;
      return;
    }
    const since = this.#drawn ? performance.now() - this.#drawn + this.#age : Infinity;
    const old = since > OLD_MS || state.camera.state !== "running";
    this.note.hidden = !old;
    if (!old) return;
    const age = Number.isFinite(since) ? `The picture is ${(since / 1000).toFixed(1)} s old` : "No picture yet";
    this.note.textContent = state.camera.reason ? `${age}: ${state.camera.reason}` : `${age}.`;
  }
}
