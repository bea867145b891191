/** Of these tables: a daemon whose hello has another gives its own at stream/schema.json. */
export const SCHEMA: "a7115c6e4d5276c2";
/** @typedef {{name: string, coding: string, boolean?: boolean, bits?: number, unit?: string, names?: string[], flags?: string[]}} Field */
/** @typedef {{id: number, name: string, channel: string, form: string, keys?: number, fields: Field[]}} Layout */
/** @type {readonly Layout[]} */
export const RECORDS: readonly Layout[];
export type Field = {
    name: string;
    coding: string;
    boolean?: boolean;
    bits?: number;
    unit?: string;
    names?: string[];
    flags?: string[];
};
export type Layout = {
    id: number;
    name: string;
    channel: string;
    form: string;
    keys?: number;
    fields: Field[];
};
