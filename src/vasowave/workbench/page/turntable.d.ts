// What report and workbench share: `turntable.js` is no module, and its types are those of every page.

type Vector = [number, number, number];
type Pixels = [number, number];

/** Things in space as they are seen. */
interface SpaceView {
    pen: CanvasRenderingContext2D;
    rotate(yaw: number, pitch: number): void;
    /** Pixels per cm. */
    unit(): number;
    /** Where a point is seen, in pixels, and how far away, from 0 (near) to 1. */
    project(point: readonly number[]): Vector;
    line(from: readonly number[], to: readonly number[], width: number, color: string, dash?: number[]): void;
    spot(center: readonly number[], color: string, radius: number): void;
    scaleBar(color: string): void;
    redraw(): void;
}

type Turntable = (
    canvas: HTMLCanvasElement,
    points: readonly (readonly number[])[],
    draw: (view: SpaceView) => void,
    pick: (x: number, y: number) => void,
) => SpaceView;

declare const turntable: Turntable;
