() => {
  // Every state that the page can reach, entered without the program: from now on the page hears
  // only what is said here. `measure` returns where everything lies that can be clicked.
  const { connection } = globalThis.clearway;
  const words = (count) => `${"The robot holds because of a reason that takes many words to be said. ".repeat(8).slice(0, count - 1)}.`;
  const LONG = words(300);
  const emit = connection.emit.bind(connection);
  const base = structuredClone(globalThis.lastState);
  const hello = structuredClone(globalThis.lastHello);
  const by = (id) => document.getElementById(id);
  connection.emit = () => {};
  connection.ask = async (message) => (message.type === "preview" ? globalThis.preview : { ok: true });

  const changed = (part, into) => {
    for (const [key, value] of Object.entries(part)) {
      if (value && typeof value === "object" && !Array.isArray(value) && into[key]) changed(value, into[key]);
      else into[key] = value;
    }
    return into;
  };
  const state = (part = {}) => emit("state", changed(part, structuredClone(base)));
  const key = (name, on = by("stage")) => on.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true }));
  const moment = () => new Promise((resolve) => setTimeout(resolve, 60));
  const refuse = async () => { // an order that is answered with a long sentence
    const ask = connection.ask;
    connection.ask = async () => ({ ok: false, error: LONG });
    key("Enter");
    await moment();
    connection.ask = ask;
  };
  const found = {
    ok: true, length_m: 12.345, clearance_m: 0.1234, duration_s: 123.4, radius_m: 0.09, narrowest_m: [1, 1],
    points: [[0.2, 0.9], [0.6, 1.5]], remarks: [],
  };
  const draft = async (preview, stations = 1) => {
    key("Escape", document.body);
    globalThis.preview = preview;
    key("Enter");
    for (let more = 1; more < stations; more += 1) {
      key("ArrowLeft");
      key("a");
    }
    await moment();
  };
  const station = { x_m: 0.3, y_m: 1.5, heading_rad: null, dwell_s: 0 };
  const mine = { seat: { ...base.seat, id: "somebody", name: "W".repeat(40), free_in_s: 99 } };
  const down = () => {
    connection.isUp = false;
    connection.lostReason = LONG;
    emit("down");
  };

  const STATES = {
    driving: () => state({ mission: { state: "driving", sentence: `driving, ${LONG}`, stations: [station, station], visited: 1 }, link: { moving: true }, to_go_m: 1234.56 }),
    planning: () => state({ mission: { state: "planning", sentence: "planning", stations: [station] } }),
    paused: () => state({ paused: true, mission: { state: "holding", sentence: "paused by the operator", stations: [station] } }),
    holding: () => state({ mission: { state: "holding", sentence: LONG, reasons: [words(200), words(120), words(90), words(60)], stations: [station] } }),
    failed: () => state({ mission: { state: "failed", sentence: LONG, reasons: [words(90)], stations: [station] } }),
    done: () => state({ mission: { state: "done", sentence: "arrived", stations: [station], visited: 1 } }),
    stopped: () => state({ mission: { state: "stopped", sentence: "stopped by somebody" }, link: { estopped: true } }),
    "stopped, a long reason": () => state({ mission: { state: "stopped", sentence: LONG }, link: { reason: LONG } }),
    "link down": () => state({ mission: { state: "holding", sentence: LONG }, link: { reason: LONG, heard_ms: 9999 } }),
    "link's counters": () => state({ link: { taken_back: 12345, stray_hellos: 12345, clock_jumps: 12345, stale: 12345, retransmits: 123456, crc_errors: 123456 } }),
    "camera lost": () => state({ mission: { state: "holding", sentence: LONG }, camera: { state: "lost", reason: LONG, reopened: 12345, dropped: 123456 }, pose: null }),
    "control loop hangs": () => state({ loop_ms: 5000 }),
    "somebody else holds the arena": () => state(mine),
    "looking only": () => { emit("hello", { ...hello, role: "visitor" }); state(); },
    "an operator again": () => { emit("hello", hello); state(); },
    "a goal, planning": () => { state(); return draft(null); },
    "a goal with its plan": () => draft(found),
    "a goal with remarks": () => draft({ ...found, remarks: [words(200), words(200)] }),
    "a goal without a plan": () => draft({ ok: false, reason: LONG, bottleneck: null, remarks: [words(200)] }),
    "twenty stations": () => draft(found, 20),
    refused: () => refuse(),
    "refused and stopped": () => state({ mission: { state: "stopped", sentence: LONG }, link: { estopped: true } }),
    "refused and lost": down,
    "lost without a reason": () => { connection.lostReason = ""; emit("down"); },
    "a token is wanted": () => { emit("token", 401); emit("down"); },
    "the connection is back": () => { connection.isUp = true; emit("up"); emit("hello", hello); state(); },
    "no goal again": () => { key("Escape", document.body); state(); },
    "a long log": () => emit("log", { items: Array.from({ length: 60 }, (_, n) => [n, "warn", LONG]) }),
    "the cursor in the arena": () => key("ArrowUp"),
    "layers off": () => document.querySelectorAll("#layers input").forEach((input) => input.click()),
    "a plan with remarks": () => emit("plan", { number: 99, ...found, remarks: [words(200)], arrays: { points: new Float32Array([0.2, 0.9, 0.6, 1.5]) } }),
    "layers on": () => document.querySelectorAll("#layers input").forEach((input) => input.click()),
    "calm again": () => { by("refusal-close").click(); state(); },
  };

  const nameOf = (one) => one.id || one.textContent.trim() || one.tagName;
  const isReached = (one, box) => { // what a click on its middle, or a third of the arena's, meets
    const parts = one.id === "stage" ? [0.04, 0.35, 0.65, 0.96] : [0.5];
    return parts.every((px) => parts.every((py) => {
      const hit = document.elementFromPoint(box.left + px * box.width, box.top + py * box.height);
      return hit !== null && one.contains(hit);
    }));
  };
  const measure = () => Object.fromEntries(
    [...document.querySelectorAll("button, input, select, #stage, #log, a[href]:not(.skip)")]
      .filter((one) => one.checkVisibility({ visibilityProperty: true }))
      .map((one) => {
        const box = one.getBoundingClientRect();
        if (one.id === "log") box.height = 16; // it grows with its lines: the first one counts
        const place = [box.left, box.top, box.width, box.height].map((v) => Math.round(10 * v) / 10);
        return [nameOf(one), { place, reached: isReached(one, box) }];
      }),
  );
  const settled = () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  const enter = async (name) => {
    await STATES[name]();
    await settled();
    return measure();
  };
  globalThis.stillness = { names: Object.keys(STATES), enter, measure, calm: state };
}
