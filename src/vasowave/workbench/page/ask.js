// Questions to the server, all below the address that carries the key.

async function answered(reply) {
  if (reply.ok) return reply;
  let text = "";
  try {
    const body = await reply.text();
    text = body.startsWith("{") ? JSON.parse(body).error : body;
  } catch { /* the sentence below */ }
  throw new Error(text || `the workbench answers ${reply.status}`);
}

/** An answer, taken as `kind` says; a workbench may end before it, or in the middle of it. */
async function fetched(where, how, kind) {
  try {
    return await (await answered(await fetch(where, how)))[kind]();
  } catch (error) {
    if (error instanceof TypeError) throw new Error("The workbench does not answer: try again, or start `vasowave open` again if it has ended. What was done is in the files.");
    throw error;
  }
}

const address = (what, given = {}) => `${what}?${new URLSearchParams(given)}`;

/** What is at an address, as a value. */
export const ask = (what, given = {}, signal = undefined) => fetched(address(what, given), { signal }, "json");

/** Numbers of four bytes at an address. */
export const numbers = async (what, given, signal = undefined) =>
  new Float32Array(await fetched(address(what, given), { signal }, "arrayBuffer"));

/** What is at an address, byte by byte. */
export const bytes = (what, given) => fetched(address(what, given), {}, "arrayBuffer");

const posted = (what, message, kind, signal) => fetched(what, {
  method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(message), signal }, kind);

/** The answer to a message. */
export const post = (what, message, signal = undefined) => posted(what, message, "json", signal);

/** The file that a message asks for. */
export const file = (what, message) => posted(what, message, "blob");

/** Send a file under a name; returns its name in the study. */
export const upload = async (name, content) =>
  (await fetched(address("upload", { name }), { method: "PUT", body: content }, "json")).name;

const said = document.getElementById("said");
let leaving = 0;

/** Say a sentence; what went wrong stays until the next. */
export function say(text, wrong = false) {
  clearTimeout(leaving);
  said.textContent = text;
  said.hidden = !text;
  said.className = wrong ? "wrong" : "";
  said.setAttribute("role", wrong ? "alert" : "status");
  if (text && !wrong) leaving = setTimeout(() => say(""), 12000);
}

const listeners = new Set();
/** Call a function after every change that this page made. */
export const afterChange = (done) => { listeners.add(done); };

/** Do something to the study; says what came of it, and returns it, or null if it was refused. */
export async function act(what, given = {}, quiet = false) {
  try {
    const answer = (await post("act", { do: what, ...given })).said;
    const text = typeof answer === "string" ? answer : (answer.said || []).join("\n");
    if (!quiet) say(text);
    await Promise.all([...listeners].map((done) => done()));
    return answer;
  } catch (error) {
    say(error.message, true);
    await Promise.all([...listeners].map((done) => done()));
    return null;
  }
}
