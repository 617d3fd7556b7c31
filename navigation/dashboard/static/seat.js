// Who holds the arena. A free arena is taken by the first order; it can be taken and left by hand.

export class Seat {
  #mine = "";
  #state = null;
  /** Taken, but no state tells of it yet: orders need not wait for one. */
  #granted = false;

  constructor(connection) {
    this.connection = connection;
    this.role = "operator";
    this.button = document.getElementById("seat");
    this.text = document.getElementById("seat-text");
    this.button.addEventListener("click", () => this.toggle());
    connection.on("hello", (hello) => { this.role = hello.role; });
    connection.on("joined", (joined) => {
      this.#mine = joined.seat;
      this.name.placeholder = joined.name;
    });
    this.name = document.getElementById("name");
    this.name.value = localStorage.getItem("clearway.name") ?? "";
    this.name.addEventListener("change", () => {
      localStorage.setItem("clearway.name", this.name.value.trim());
      connection.join();
    });
    connection.on("state", (state) => {
      this.#state = state;
      if (state.seat) this.#granted = false;
      this.#show();
    });
    connection.on("down", () => { this.#granted = false; this.#show(); });
  }

  get mayDrive() {
    return this.role === "operator";
  }

  /** Without a token, where looking needs none: may not even stop. */
  get isVisitor() {
    return this.role === "visitor";
  }

  get isMine() {
    return this.#granted || (Boolean(this.#mine) && this.#state?.seat?.id === this.#mine);
  }

  async toggle() {
    if (!this.mayDrive) return;
    if (this.isMine) {
      this.#granted = false;
      this.connection.send({ type: "release" });
    } else {
      await this.takeIfFree();
    }
  }

  /** Make sure that this page holds the arena; {ok, error}. */
  async takeIfFree() {
    if (this.isMine) return { ok: true };
    const answer = await this.connection.ask({ type: "take" });
    this.#granted = answer.ok;
    return answer;
  }

  #show() {
    const up = this.connection.isUp && this.#state !== null;
    const holder = this.#state?.seat;
    this.button.hidden = !up || !this.mayDrive || (Boolean(holder) && !this.isMine);
    this.button.textContent = this.isMine ? "Release" : "Take arena";
    if (!up) this.text.textContent = "";
    else if (this.isMine) this.text.textContent = "You hold the arena";
    else if (holder) this.text.textContent = `${holder.name} holds the arena`;
    else this.text.textContent = this.mayDrive ? "" : "Looking only";
    const others = (this.#state?.viewers ?? 1) - 1;
    this.text.title = others > 0 ? `${others} more ${others === 1 ? "page is" : "pages are"} open` : "";
  }
}
