// What the server answers and what modules hand to one another; JSON of vasowave/workbench/*.py.

/** A number; null where there is none, or none that is finite. */
export type Value = number | null;
/** A value with the ends of its interval. */
export type Estimate = [Value, Value, Value];
/** x, y, z in cm along the image's axes, and the radius there. */
export type AxisPoint = [number, number, number, number];
export type Color = [number, number, number];
export type Query = Record<string, string | number>;

/** What `h` puts into an element. */
export type Child = Node | string | number | false | null | undefined | readonly Child[];
export interface Attributes {
    onclick?: (event: MouseEvent) => unknown;
    ondragover?: (event: DragEvent) => unknown;
    ondragleave?: (event: DragEvent) => unknown;
    ondrop?: (event: DragEvent) => unknown;
    [name: string]: unknown;
}
/** A value, or a value with what is shown for it. */
export type Option = string | [string, string];

// state

export interface AnimalStatus {
    state: string;
    text: string;
}
export interface Progress {
    runner: string | null;
    /** Seconds. */
    left: Value;
    animals: Record<string, AnimalStatus>;
    ended: string | null;
    said: string;
    stops_with_us: boolean;
}
export interface WorkbenchState {
    mark: string;
    study: boolean;
    report: boolean;
    results: boolean;
    undo: string;
    redo: string;
    /** Files that were saved beside the recordings meanwhile. */
    arrived: number;
    run: Progress;
}
/** A desk: a module that shows itself in an element. */
export interface DeskModule {
    show(place: HTMLElement, path: string[], state: WorkbenchState | null): Promise<void>;
    renew(place: HTMLElement, path: string[], state: WorkbenchState | null): Promise<void>;
    progress?(place: HTMLElement, state: WorkbenchState): void;
}

// study, check

export type Row = Record<string, string>;
export interface Message {
    do: string;
    [name: string]: unknown;
}
export interface Remedy {
    label: string;
    /** What it will change, in words. */
    changes: string;
    /** The animal whose recording is to be looked at. */
    open?: string;
    desk?: string;
    /** Key of the field in which a person types what is lacking. */
    type?: string;
    acts?: Message[];
}
export interface Problem extends Finding {
    place: string;
    error: boolean;
    animals: string[];
    column: string;
}
export interface Setting {
    key: string;
    value: string;
    meaning: string;
}
export interface EmptyFolder {
    study: false;
    folder: string;
    species: string[];
}
export interface StudyAnswer {
    study: true;
    programs: { name: string; path: string; sha256: string; text: string }[];
    folder: string;
    title: string;
    groups: string[];
    /** Title, meaning, and whether it is needed. */
    columns: [string, string, boolean][];
    files: string[];
    words: Record<string, string[]>;
    titles: string[];
    /** Title and unit of what is read of every animal. */
    header: [string, string][];
    rows: Row[];
    networks: string[];
    problems: Problem[];
    settings: Setting[];
    status: Record<string, AnimalStatus>;
    outdated: string[];
    /** The folder whose new files become rows. */
    watched: string;
    /** Files there that are in no row. */
    unlisted: string[];
}
export interface CheckAnswer {
    problems: Problem[];
    /** What asks for nothing, once for all animals alike. */
    notes: Problem[];
    read: Record<string, string[]>;
}

// recording

export interface Beats {
    starts: number[];
    end: number;
    averaged: number[];
    rejected: Record<number, string>;
    causes: Record<number, string>;
}
/** Action, time, and where to: seconds. */
export type BeatEdit = [string, number, Value];
export interface Finding {
    code: string;
    text: string;
    look: boolean;
    remedies: Remedy[];
}
export interface Cycle {
    period: number;
    pressure: Value[];
    flow: Value[];
    indices: Record<string, Value>;
    findings: Finding[];
    sd?: { pressure: Value[]; flow: Value[] };
}
export interface RecordingAnswer extends Partial<Cycle> {
    animal: string;
    cells: Record<string, string>;
    drift: string;
    kind: string;
    edits: BeatEdit[];
    error: string;
    remedies?: Remedy[];
    labels: Record<string, string>;
    units: Record<string, string>;
    /** Title, unit, and the quantity that it holds. */
    channels?: [string, string, string][];
    blocks?: number;
    duration?: number;
    /** Time in s, and text. */
    comments?: [number, string][];
    signals?: string[];
    from?: number;
    to?: number;
    beats?: Beats;
}

// results, model, simulate, band, means

export interface AnimalNumbers {
    name: string;
    group: string;
    /** Numbers by source and quantity. */
    laws: Record<string, Record<string, Estimate>>;
}
export interface FigureChoices {
    panels: Record<string, string>;
    /** Figures of groups, with what they show. */
    of_groups: Record<string, string>;
    families: string[];
    formats: string[];
}
export interface ResultsAnswer {
    animals: AnimalNumbers[];
    /** Colors by group. */
    groups: Record<string, string>;
    reference: string;
    /** Symbol, unit and meaning. */
    quantities: Record<string, [string, string, string]>;
    /** Whether its marks are filled. */
    sources: Record<string, boolean>;
    failures: string[];
    figure: FigureChoices;
}
/** Means by source and group. */
export type Means = Record<string, Record<string, Estimate>>;
export interface Knob {
    name: string;
    symbol: string;
    unit: string;
    meaning: string;
    value: number;
    low: number;
    high: number;
    interval: [number, number] | null;
}
export interface Tree {
    axes: [Vector, Vector][];
    radius: number[];
}
export interface ModelAnswer {
    animal: string;
    law: string;
    laws: string[];
    made: number;
    formula: string;
    knobs: Knob[];
    measured: { pressure: Value[]; flow: Value[]; period: number; modulus: Value[] };
    tree: Tree;
    stops: Color[];
    panels: Record<string, string>;
    units: Record<string, string>;
    colors: string[];
    moving: string[];
    moments: number;
}
export type CurveName = "pressure" | "flow" | "forward" | "backward" | "modulus";
export type Curves = Record<CurveName, Value[]>;
export interface Simulation extends Curves {
    period: number;
    indices: Record<string, Value>;
    vessels: Record<string, Value[]>;
    frames: Record<string, number[][]>;
    notes: string[];
}
/** By name: before, after, change, and the ends of the change's interval. */
export interface PredictionAnswer {
    labels: Record<string, string>;
    units: Record<string, string>;
    rows: Record<string, Value[]>;
    remarks: string[];
}
export interface Draws {
    kind: string;
    count: number;
    curves: Partial<Curves>[];
    values: Record<string, Value[]>;
}
export interface BandAnswer {
    band: Partial<Record<CurveName, [Value[], Value[]]>>;
    draws: Draws;
}

// lung, vessels

export interface Wishes {
    threshold: number | null;
    cannula: number | null;
    pressure: number | null;
    voxel: string | null;
    species: string;
    open_loops: boolean;
}
export interface LungAnswer {
    images: string[];
    image: string;
    file: string;
    stage: string;
    species: string[];
    wishes: Wishes;
    /** Line and text. */
    edits: [number, string][];
    root: boolean;
    "file of edits": string;
    written: boolean;
    outdated: boolean;
}
export interface Vessel {
    name: string;
    parent: string;
    terminal: boolean;
    length: Value;
    radius: Value;
    sd: Value;
    reliable: boolean;
    points: AxisPoint[];
    doubts: string[];
}
export interface Doubt {
    about: string;
    text: string;
    vessels: string[];
    places: Vector[];
}
export interface VesselsAnswer {
    vessels: Vessel[];
    doubts: Doubt[];
    notes: string[];
    root: Vector;
    /** Per cent. */
    scale: Value;
    generations: number;
    /** cm. */
    total: number;
}
