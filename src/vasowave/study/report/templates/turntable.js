// @ts-check
// Things in space on a canvas: drag or arrow keys turn, wheel or + and - zoom, a click picks a place.
// deno-lint-ignore no-unused-vars -- scripts after this one call it
const turntable = /** @type {Turntable} */ ((canvas, points, draw, pick) => {
    "use strict";
    const AXES = [0, 1, 2];
    const low = AXES.map((k) => Math.min(...points.map((point) => point[k])));
    const high = AXES.map((k) => Math.max(...points.map((point) => point[k])));
    const middle = low.map((value, k) => (value + high[k]) / 2);
    const size = Math.max(...high.map((value, k) => value - low[k]));
    // Rows: right, down, away from the viewer. At first x points right and z up.
    let turn = [[1, 0, 0], [0, 0, -1], [0, 1, 0]];
    let zoom = 1, moved = false;
    /** @type {Pixels | null} */
    let drag = null;
    /**
     * @param {number[][]} a
     * @param {number[][]} b
     */
    const times = (a, b) => a.map((row) => AXES.map((j) => row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]));

    /** @type {SpaceView} */
    const view = {
        pen: /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")),
        rotate(yaw, pitch) {
            const [a, b, c, d] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
            turn = times([[1, 0, 0], [0, c, -d], [0, d, c]], times([[a, 0, b], [0, 1, 0], [-b, 0, a]], turn));
        },
        unit: () => (0.88 * Math.min(canvas.clientWidth, canvas.clientHeight) * zoom) / size,
        project(point) {
            const from = AXES.map((k) => point[k] - middle[k]);
            const [x, y, z] = turn.map((row) => row[0] * from[0] + row[1] * from[1] + row[2] * from[2]);
            const far = Math.min(1, Math.max(0, z / size + 0.5));
            return [canvas.clientWidth / 2 + view.unit() * x, canvas.clientHeight / 2 + view.unit() * y, far];
        },
        line(from, to, width, color, dash = []) {
            Object.assign(view.pen, { strokeStyle: color, lineWidth: width, lineCap: "round" });
            view.pen.setLineDash(dash);
            view.pen.beginPath();
            view.pen.moveTo(from[0], from[1]);
            view.pen.lineTo(to[0], to[1]);
            view.pen.stroke();
        },
        spot(center, color, radius) {
            view.pen.fillStyle = color;
            view.pen.beginPath();
            view.pen.arc(center[0], center[1], radius, 0, 7);
            view.pen.fill();
        },
        scaleBar(color) {
            const bar = Math.pow(10, Math.floor(Math.log10(size / zoom / 2)));
            Object.assign(view.pen, { fillStyle: color, font: "12px sans-serif" });
            view.pen.fillRect(12, canvas.clientHeight - 14, bar * view.unit(), 2);
            view.pen.fillText(`${bar} cm`, 12, canvas.clientHeight - 20);
        },
        redraw() {
            const ratio = devicePixelRatio || 1;
            canvas.width = canvas.clientWidth * ratio;
            canvas.height = canvas.clientHeight * ratio;
            view.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
            draw(view);
        },
    };

    canvas.addEventListener("pointerdown", (event) => {
        drag = [event.offsetX, event.offsetY];
        moved = false;
        canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
        if (!drag) return;
        const [dx, dy] = [event.offsetX - drag[0], event.offsetY - drag[1]];
        if (!moved && Math.hypot(dx, dy) < 4) return;
        moved = true;
        view.rotate(-dx * 0.01, -dy * 0.01);
        drag = [event.offsetX, event.offsetY];
        view.redraw();
    });
    canvas.addEventListener("pointerup", (event) => {
        if (drag && !moved) pick(event.offsetX, event.offsetY);
        drag = null;
    });
    canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        zoom = Math.min(30, Math.max(0.5, zoom * Math.exp(-event.deltaY * 0.001)));
        view.redraw();
    }, { passive: false });
    /** @type {Record<string, Pixels>} */
    const steps = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    canvas.addEventListener("keydown", (event) => {
        const step = steps[event.key];
        if (step) view.rotate(...step);
        else if (event.key === "+" || event.key === "-") zoom *= event.key === "+" ? 1.2 : 1 / 1.2;
        else return;
        event.preventDefault();
        view.redraw();
    });
    addEventListener("resize", view.redraw);
    return view;
});
