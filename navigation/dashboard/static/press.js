// Buttons that are never dead: one that cannot do its work now keeps its place, hears every press and
// says why nothing happens.

const reasons = new WeakMap();

/** Call `act` when the button is pressed, or `say` why it cannot work now (see `allow`). */
export function onPress(button, say, act) {
  button.addEventListener("click", () => {
    const reason = reasons.get(button);
    if (reason) say(reason);
    else act();
  });
}

/** Let the button work, or not for a reason; "" is none. */
export function allow(button, reason) {
  if (reasons.get(button) === reason) return;
  reasons.set(button, reason);
  button.setAttribute("aria-disabled", String(Boolean(reason)));
}
