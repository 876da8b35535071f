// @ts-check
// As much of a document as elements need that are made without a browser.

class FakeElement extends EventTarget {
    /** @param {string} tag */
    constructor(tag) {
        super();
        this.tag = tag;
        /** @type {(FakeElement | string)[]} */
        this.children = [];
        /** @type {Record<string, string>} */
        this.dataset = {};
        /** @type {Record<string, string>} */
        this.attributes = {};
        this.className = "";
        this.value = "";
        this.scrollLeft = 0;
        this.focused = false;
    }

    /** @returns {string} */
    get textContent() {
        return this.children.map((child) => typeof child === "string" ? child : child.textContent).join("");
    }

    set textContent(text) {
        this.children = [text];
    }

    /** @returns {FakeElement[]} */
    get descendants() {
        return this.children.flatMap((child) => typeof child === "string" ? [] : [child, ...child.descendants]);
    }

    /** @param {...(FakeElement | string)} children */
    append(...children) {
        this.children.push(...children);
    }

    /** @param {...(FakeElement | string)} children */
    replaceChildren(...children) {
        this.children = children;
    }

    /**
     * @param {string} name
     * @param {string} value
     */
    setAttribute(name, value) {
        this.attributes[name] = value;
    }

    /** @param {string} selector `[data-name]` */
    querySelectorAll(selector) {
        const name = selector.slice("[data-".length, -1);
        return this.descendants.filter((element) => name in element.dataset);
    }

    /** @param {FakeElement} element */
    contains(element) {
        return this.descendants.includes(element);
    }

    focus() {
        this.focused = true;
    }
}

/**
 * Let elements be made; returns the document.
 * @returns {{ activeElement: any }}
 */
export function fakeDocument() {
    const document = { activeElement: null, createElement: (/** @type {string} */ tag) => new FakeElement(tag) };
    Object.assign(globalThis, { document });
    return document;
}
