// @ts-check
// Questions to the server, all below the address that carries the key.
/** @import { Query } from "./answers.d.ts" */

const SILENT = "The workbench does not answer: try again, or start `vasowave open` again if it has ended. " +
    "What was done is in the files.";
const NOTICE_MS = 12000;

/**
 * What a refusal says.
 * @param {string} body
 * @param {number} status
 */
export function refusal(body, status) {
    let text = body;
    try {
        if (body.startsWith("{")) text = JSON.parse(body).error;
    } catch {
        text = "";
    }
    return text || `the workbench answers ${status}`;
}

/** @param {Response} response */
async function accepted(response) {
    if (response.ok) return response;
    throw new Error(refusal(await response.text().catch(() => ""), response.status));
}

/**
 * An answer, read as `read` does; a workbench may end before it, or in the middle of it.
 * @template Answer
 * @param {string} address
 * @param {RequestInit} options
 * @param {(response: Response) => Promise<Answer>} read
 */
async function request(address, options, read) {
    try {
        return await read(await accepted(await fetch(address, options)));
    } catch (error) {
        if (error instanceof TypeError) throw new Error(SILENT);
        throw error;
    }
}

/** @param {Response} response */
const json = (response) => response.json();

/** @param {Response} response */
const buffer = (response) => response.arrayBuffer();

/**
 * @param {string} route
 * @param {Query} [query]
 */
export const addressOf = (route, query = {}) =>
    `${route}?${new URLSearchParams(Object.entries(query).map(([name, value]) => [name, String(value)]))}`;

/**
 * The JSON at an address.
 * @param {string} route
 * @param {Query} [query]
 * @param {AbortSignal} [signal]
 * @returns {Promise<any>}
 */
export const ask = (route, query, signal) => request(addressOf(route, query), { signal }, json);

/**
 * Numbers of four bytes at an address.
 * @param {string} route
 * @param {Query} query
 * @param {AbortSignal} [signal]
 */
export const numbers = async (route, query, signal) =>
    new Float32Array(await request(addressOf(route, query), { signal }, buffer));

/**
 * What is at an address, byte by byte.
 * @param {string} route
 * @param {Query} query
 */
export const bytes = (route, query) => request(addressOf(route, query), {}, buffer);

/**
 * @template Answer
 * @param {string} route
 * @param {unknown} message
 * @param {(response: Response) => Promise<Answer>} read
 */
const posted = (route, message, read) =>
    request(route, {
        method: "POST",
        headers: { "content-type": "application/json" },
        body: JSON.stringify(message),
    }, read);

/**
 * The answer to a message.
 * @param {string} route
 * @param {unknown} message
 * @returns {Promise<any>}
 */
export const post = (route, message) => posted(route, message, json);

/**
 * The file that a message asks for.
 * @param {string} route
 * @param {unknown} message
 */
export const file = (route, message) => posted(route, message, (response) => response.blob());

/**
 * Send a file under a name; returns its name in the study.
 * @param {string} name
 * @param {Blob} content
 * @returns {Promise<string>}
 */
export const upload = async (name, content) =>
    (await request(addressOf("upload", { name }), { method: "PUT", body: content }, json)).name;

/** @type {{ timer?: ReturnType<typeof setTimeout>, listeners: Set<() => unknown> }} */
const state = { listeners: new Set() };

/**
 * Show a sentence; an error stays until the next.
 * @param {string} text
 * @param {boolean} [wrong]
 */
export function notify(text, wrong = false) {
    const line = /** @type {HTMLElement} */ (document.getElementById("said"));
    clearTimeout(state.timer);
    line.textContent = text;
    line.className = wrong ? "wrong" : "";
    if (line.parentElement) line.parentElement.hidden = !text;
    line.setAttribute("role", wrong ? "alert" : "status");
    if (text && !wrong) state.timer = setTimeout(() => notify(""), NOTICE_MS);
}

/** @param {unknown} error */
export const messageOf = (error) => error instanceof Error ? error.message : String(error);

/** @param {unknown} error */
export const complain = (error) => notify(messageOf(error), true);

/**
 * Call a function after every change that this page made.
 * @param {() => unknown} done
 */
export const afterChange = (done) => void state.listeners.add(done);

const changed = () => Promise.all([...state.listeners].map((done) => done()));

/**
 * Do something to the study; shows what came of it, and returns it, or null if it was refused.
 * @param {string} action
 * @param {object} [values]
 * @param {boolean} [quiet]
 * @returns {Promise<string | { said?: string[] } | null>}
 */
export async function act(action, values = {}, quiet = false) {
    try {
        const answer = (await post("act", { do: action, ...values })).said;
        if (!quiet) notify(typeof answer === "string" ? answer : (answer.said || []).join("\n"));
        await changed();
        return answer;
    } catch (error) {
        complain(error);
        await changed();
        return null;
    }
}
