// A client whose requests and answers have the types of api/openapi.yaml (`api.ts`, made by openapi-typescript).
import type { paths } from './api.js';

type Method = 'get' | 'put' | 'post' | 'patch' | 'delete';
type Methods<P extends keyof paths> = { [M in Method]: paths[P][M] extends undefined ? never : M }[Method];
type Operation<P extends keyof paths, M extends Method> = NonNullable<paths[P][M]>;
type Content<T> = T extends { content: infer C } ? C[keyof C] : undefined;

type InPath<O> = O extends { parameters: { path: infer V } } ? { path: V } : { path?: undefined };
type InQuery<O> = O extends { parameters: { query?: infer Q } } ? { query?: Q } : { query?: undefined };
type InBody<O> = O extends { requestBody: infer B } ? { body: Content<B> }
  : O extends { requestBody?: infer B } ? { body?: Content<NonNullable<B>> } : { body?: undefined };
export type Wish<O> = InPath<O> & InQuery<O> & InBody<O> & { key?: string, headers?: Record<string, string> };
/** By status, so that `answer.status === 201` narrows the type of `answer.body`. */
export type Answer<O> = O extends { responses: infer R } ? { [S in keyof R]: { status: S, headers: Headers, body: Content<R[S]> } }[keyof R] : never;

/** `used` gets `get /api/v1/...` of each operation that is called. */
export function client(url: string, used: Set<string>) {
  return async function call<P extends keyof paths, M extends Methods<P> & Method>(method: M, path: P, wish: Wish<Operation<P, M>>):
    Promise<Answer<Operation<P, M>>> {
    const { path: values, query, body, key, headers } = wish as { path?: object, query?: object, body?: unknown, key?: string, headers?: object };
    const full = new URL(path.replace(/{(\w+)}/g, (_, name: string) => String((values as Record<string, unknown>)[name])), url);
    for (const [name, value] of Object.entries(query ?? {})) full.searchParams.set(name, String(value));
    used.add(`${method} ${path}`);
    const answer = await fetch(full, { method: method.toUpperCase(), body: body === undefined ? undefined : JSON.stringify(body),
      headers: { ...(body === undefined ? {} : { 'content-type': 'application/json' }), ...(key === undefined ? {} : { authorization: `Bearer ${key}` }),
        ...headers } });
    const json = /[/+]json\b/.test(answer.headers.get('content-type') ?? '') && answer.status !== 204;
    const text = await answer.text();
    return { status: answer.status, headers: answer.headers, body: json ? JSON.parse(text) : text === '' ? undefined : text } as Answer<Operation<P, M>>;
  };
}
