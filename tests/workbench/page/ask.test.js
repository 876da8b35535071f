// @ts-check
import { deepEqual, equal, rejects } from "node:assert/strict";
import {
    addressOf,
    ask,
    file,
    messageOf,
    numbers,
    post,
    refusal,
    upload,
} from "../../../src/vasowave/workbench/page/ask.js";

/**
 * Let the server answer so; returns what it was asked.
 * @param {() => Response} answer
 */
function served(answer) {
    /** @type {[string, RequestInit][]} */
    const asked = [];
    globalThis.fetch = (address, options = {}) => {
        asked.push([String(address), options]);
        return Promise.resolve().then(answer);
    };
    return asked;
}

Deno.test("an address holds its question in the words of a URL", () => {
    equal(addressOf("model", { animal: "CTL 1&2", law: "" }), "model?animal=CTL+1%262&law=");
    equal(addressOf("trace", { start: 0.5, width: 800 }), "trace?start=0.5&width=800");
    equal(addressOf("state"), "state?");
});

Deno.test("a refusal says its error, its text, or its number", () => {
    equal(refusal('{"error": "no such animal"}', 400), "no such animal");
    equal(refusal("not found", 404), "not found");
    equal(refusal("{broken", 500), "the workbench answers 500");
    equal(refusal('{"other": 1}', 500), "the workbench answers 500");
    equal(refusal("", 408), "the workbench answers 408");
});

Deno.test("an answer is JSON, numbers of four bytes, or a file", async () => {
    served(() => Response.json({ a: 1 }));
    deepEqual(await ask("state"), { a: 1 });
    served(() => new Response(new Float32Array([1.5, NaN]).buffer));
    deepEqual([...await numbers("trace", {})], [1.5, NaN]);
    served(() => new Response("svg"));
    equal(await (await file("figure", {})).text(), "svg");
});

Deno.test("a message goes as JSON, a file under its name", async () => {
    const asked = served(() => Response.json({ name: "b" }));
    await post("act", { do: "undo" });
    equal(await upload("a b", new Blob(["x"])), "b");
    deepEqual(asked.map(([address, { method }]) => [address, method]), [["act", "POST"], ["upload?name=a+b", "PUT"]]);
    equal(asked[0][1].body, '{"do":"undo"}');
});

Deno.test("what is refused is an error, and a server that is gone says how to start it", async () => {
    served(() => Response.json({ error: "no" }, { status: 400 }));
    await rejects(ask("state"), /^Error: no$/);
    served(() => {
        throw new TypeError("Failed to fetch");
    });
    await rejects(ask("state"), /start `vasowave open` again/);
});

Deno.test("an error has its message, anything else its text", () => {
    equal(messageOf(new Error("a")), "a");
    equal(messageOf("b"), "b");
});
