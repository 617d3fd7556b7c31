// Control of the arena. A free arena is taken by the first order; it can be taken and left by hand.

const NO_TOKEN = "this page has no token that may drive";
const RECORDING = "this is a recording: nothing here drives or stops a robot";

export class Seat {
  #mine = "";
  #state = null;
  /** Taken, but no state says so yet: orders need not wait for one. */
  #granted = false;

  constructor(connection, say) {
    Object.assign(this, { connection, say });
    this.role = "operator";
    this.button = document.getElementById("seat");
    this.text = document.getElementById("seat-text");
    this.button.addEventListener("click", (event) => {
      if (event.detail < 2) this.toggle(); // a double click does not take and release
    });
    connection.on("hello", (hello) => { this.role = hello.role; });
    connection.on("notice", (notice) => say(notice.text));
    connection.on("joined", (joined) => {
      this.#mine = joined.seat;
      this.name.placeholder = "somebody";
    });
    this.name = document.getElementById("name");
    this.name.value = localStorage.getItem("clearway.name") ?? "";
    this.name.addEventListener("change", () => {
      localStorage.setItem("clearway.name", this.name.value.trim());
      connection.join();
    });
    this.#askName();
    connection.on("state", (state) => {
      this.#state = state;
      if (state.seat) this.#granted = false;
      this.#show();
    });
    connection.on("down", () => { this.#granted = false; this.#show(); });
  }

  /** Ask once for the name of the person in control; it may be empty. */
  #askName() {
    this.form = document.getElementById("name-form");
    const asked = document.getElementById("name-asked");
    const keep = (name) => {
      this.name.value = name;
      localStorage.setItem("clearway.name", name);
      this.form.hidden = true;
      this.connection.join();
    };
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      keep(asked.value.trim());
    });
    asked.addEventListener("keydown", (event) => { if (event.key === "Escape") keep(""); });
  }

  get mayDrive() {
    return this.role === "operator" || this.isSupervisor;
  }

  /** May take control from anyone, by the button: not by a click in the arena. */
  get isSupervisor() {
    return this.role === "supervisor";
  }

  /** Reason why nobody may drive from this page, or "". */
  get mayNot() {
    if (this.isRecording) return RECORDING;
    return this.mayDrive ? "" : NO_TOKEN;
  }

  /** There is no robot at the other end. */
  get isRecording() {
    return this.role === "nobody";
  }

  /** Has no token, where looking needs none: may not even stop. */
  get isVisitor() {
    return this.role === "visitor";
  }

  get isMine() {
    return this.#granted || (Boolean(this.#mine) && this.#state?.seat?.id === this.#mine);
  }

  /** The name of another holder of the arena, or "". */
  get other() {
    return this.isMine ? "" : this.#state?.seat?.name ?? "";
  }

  async toggle() {
    let answer = { ok: false, error: "there is no connection to the program" };
    if (!this.mayDrive) {
      answer.error = this.mayNot;
    } else if (!this.isMine) {
      answer = await this.#take();
    } else if (this.connection.send({ type: "release" })) {
      this.#granted = false;
      answer = { ok: true };
    }
    this.say(answer.ok ? "" : answer.error);
  }

  /** Make sure that this page holds the arena; {ok, error}. */
  async takeIfFree() {
    if (this.isMine) return { ok: true };
    if (this.isRecording) return { ok: false, error: RECORDING };
    if (this.isSupervisor && this.other) {
      return { ok: false, error: `${this.other} is in control: press "Take control" to take it from them` };
    }
    return this.#take();
  }

  async #take() {
    const answer = await this.connection.ask({ type: "take" });
    this.#granted = answer.ok;
    return answer;
  }

  #show() {
    if (this.isRecording) return; // the bar says what is played
    const up = this.connection.isUp && this.#state !== null;
    const holder = this.#state?.seat;
    this.form.hidden = !((up || this.form.contains(document.activeElement)) && this.isMine
      && localStorage.getItem("clearway.name") === null
      && this.#state.mission.state !== "stopped"); // what became of a STOP needs the room
    this.button.hidden = this.#state === null || !this.mayDrive || (Boolean(holder) && !this.isMine && !this.isSupervisor);
    this.button.textContent = this.isMine ? "Release" : "Take control";
    if (!up) this.text.textContent = "";
    else if (this.isMine) this.text.textContent = "You are in control";
    else if (holder) this.text.textContent = `${holder.name} is in control`;
    else this.text.textContent = this.mayNot && !this.isRecording ? "Looking only" : "";
    const others = (this.#state?.viewers ?? 1) - 1;
    this.text.title = others > 0 ? `${others} more ${others === 1 ? "page is" : "pages are"} open` : "";
  }
}
