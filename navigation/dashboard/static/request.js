// A question or an order to the program over HTTP; its answer, or `{ok: false, error}` with a sentence.

/** `body` makes an order of a question. */
export async function request(connection, address, body) {
  const options = { headers: { ...connection.authorization } };
  if (body) {
    options.method = "POST";
    options.headers["Content-Type"] = "application/json";
    options.body = JSON.stringify(body);
  }
  try {
    const answer = await fetch(address, options);
    if (answer.ok) return await answer.json();
    return { ok: false, error: (await answer.text()).trim() };
  } catch {
    return { ok: false, error: "there is no connection to the program" };
  }
}
