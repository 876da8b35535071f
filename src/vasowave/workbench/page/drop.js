// @ts-check
// Files from a dialog or dropped, folders with all that is in them.
import { act, messageOf, notify, upload } from "./ask.js";
import { h, input, labelled } from "./dom.js";

/** @typedef {[string, File]} NamedFile */

const NO_DATA = /(^|\/)([.~]|Thumbs\.db$)|\.(docx?|gif|html?|ini|jpe?g|lnk|log|md|odt|pdf|png|pptx?|svg|zip)$/i;

/**
 * Where files are dropped or chosen.
 * @param {() => object} [study] what a study that is made for them is to be, a species
 */
export function dropZone(study = () => ({})) {
    const chooser = (/** @type {object} */ attributes, /** @type {string} */ text) =>
        labelled(
            input(
                { type: "file", multiple: true, ...attributes },
                ({ files }) =>
                    take([...files ?? []].map((file) => [file.webkitRelativePath || file.name, file]), study()),
            ),
            text,
        );
    /** @type {HTMLDivElement} */
    const zone = h(
        "div",
        {
            class: "drop",
            ondragover: (event) => {
                event.preventDefault();
                zone.classList.add("over");
            },
            ondragleave: () => zone.classList.remove("over"),
            ondrop: async (event) => {
                event.preventDefault();
                zone.classList.remove("over");
                const entries = [...event.dataTransfer?.items ?? []].map((item) => item.webkitGetAsEntry?.());
                const files = entries.flatMap((entry) => entry ? [filesOf(entry, "")] : []);
                take((await Promise.all(files)).flat(), study());
            },
        },
        "Drop recordings and networks here, or choose ",
        chooser({ webkitdirectory: true, id: "folder" }, "a folder"),
        chooser({ id: "files" }, "files"),
    );
    return zone;
}

/**
 * The file of an entry, or all files of a folder, by their names from where the drop began.
 * @param {FileSystemEntry} entry
 * @param {string} folder
 * @returns {Promise<NamedFile[]>}
 */
export async function filesOf(entry, folder) {
    const name = folder + entry.name;
    if (entry.isFile) {
        const { file } = { file: /** @type {FileSystemFileEntry} */ (entry) };
        return [[name, await new Promise((done, fail) => file.file(done, fail))]];
    }
    const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
    const entries = /** @type {FileSystemEntry[]} */ ([]);
    for (;;) {
        /** @type {FileSystemEntry[]} */
        const batch = await new Promise((done, fail) => reader.readEntries(done, fail));
        if (!batch.length) return (await Promise.all(entries.map((entry) => filesOf(entry, `${name}/`)))).flat();
        entries.push(...batch);
    }
}

/**
 * Files in the order of their names, without hidden ones and those that lie beside recordings and hold no data.
 * @param {NamedFile[]} files
 */
export const sorted = (files) => files.toSorted(([a], [b]) => a < b ? -1 : 1).filter(([name]) => !NO_DATA.test(name));

/**
 * @param {NamedFile[]} given
 * @param {object} study
 */
async function take(given, study) {
    const names = [], failures = [], files = sorted(given);
    for (const [name, file] of files) {
        notify(`Copying ${names.length + 1} of ${files.length}: ${name}`);
        try {
            names.push(await upload(name, file));
        } catch (error) {
            failures.push(messageOf(error));
        }
    }
    if (!names.length) {
        notify(failures.join("\n") || "There is no file among these.", true);
        return;
    }
    const answer = await act("add-files", { files: names, ...study });
    if (!answer || !failures.length) return;
    notify([...(typeof answer === "string" ? [answer] : answer.said ?? []), ...failures].join("\n"), true);
}
