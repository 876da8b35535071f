// @ts-check
// Which desk an address names, and the words of the line about a run.

/**
 * The desk of an address, the first where it names none, and what follows.
 * @param {string} hash
 * @param {readonly string[]} desks
 */
export function routeOf(hash, desks) {
    const [desk, ...path] = hash.slice(1).split("/");
    return { desk: desks.includes(desk) ? desk : desks[0], path: path.map(decodeURIComponent) };
}

/**
 * The time that a run still takes.
 * @param {number | null} seconds
 */
export function etaOf(seconds) {
    if (seconds === null) return "";
    return `, about ${seconds < 90 ? `${Math.round(seconds)} s` : `${Math.round(seconds / 60)} min`} left`;
}
