// Answers of the daemon compared with the documents that it serves: statuses, types, headers and schemas.
import assert from 'node:assert/strict';
import Ajv from 'ajv/dist/2020.js';
import YAML from 'yaml';

/** Reads the documents of the daemon that `c` asks. @param {ReturnType<typeof import('./client.mjs').client>} c */
export async function readContract(c) {
  const api = YAML.parse((await c.get('/api/v1/openapi.yaml')).text),
    messages = YAML.parse((await c.get('/api/v1/asyncapi.yaml')).text),
    schemas = (await c.get('/api/v1/schemas.json')).json;
  const ajv = new Ajv({ strict: false, allErrors: true });
  ajv.addSchema(schemas, 'schemas.json');
  ajv.addSchema(api, 'openapi');
  ajv.addSchema(messages, 'asyncapi');
  const compiled = new Map();

  function resolve(node) {
    while (node?.$ref?.startsWith('#'))
      node = node.$ref
        .slice(2)
        .split('/')
        .reduce((at, key) => at[key.replaceAll('~1', '/')], api);
    return node;
  }
  function validator(schema) {
    if (!compiled.has(schema)) {
      const local = JSON.parse(JSON.stringify(schema), (key, value) => (key === '$ref' ? value.replace(/^#/, 'openapi#') : value));
      compiled.set(schema, ajv.compile(local));
    }
    return compiled.get(schema);
  }
  return {
    api,
    schemas,
    resolve,
    /** Fails unless the answer is one that the document has for the operation; what it is, as `get /path 200`. */
    check(method, template, answer) {
      const operation = api.paths[template][method];
      const where = `${method} ${template} ${answer.status}`;
      const response = resolve(operation.responses[String(answer.status)]);
      assert.ok(response, `${where} is not documented: ${answer.text.slice(0, 300)}`);
      for (const [name, header] of Object.entries(response.headers ?? {}))
        if (resolve(header).required) assert.ok(answer.headers[name.toLowerCase()], `${where} lacks ${name}`);
      assert.ok(answer.headers['x-request-id'], `${where} lacks X-Request-Id`);
      assert.equal(answer.headers['x-content-type-options'], 'nosniff', where);
      if (!response.content) {
        assert.equal(answer.text, '', `${where} has a body`);
        return where;
      }
      const type = (answer.headers['content-type'] ?? '').split(';')[0];
      const content = response.content[type];
      assert.ok(content, `${where} has the type ${type}`);
      if (answer.json !== undefined) {
        const validate = validator(content.schema);
        assert.ok(validate(answer.json), `${where}: ${ajv.errorsText(validate.errors).slice(0, 500)} in ${answer.text.slice(0, 400)}`);
        if (answer.status >= 400) assert.equal(answer.json.status, answer.status, where);
      }
      return where;
    },
    /** Fails unless asyncapi.yaml has such a message. */
    checkMessage(name, message) {
      const validate = ajv.getSchema(`asyncapi#/components/messages/${name}/payload`);
      assert.ok(validate, `no message is called ${name}: ${JSON.stringify(message).slice(0, 300)}`);
      assert.ok(validate(message), `${name}: ${ajv.errorsText(validate.errors).slice(0, 500)} in ${JSON.stringify(message).slice(0, 400)}`);
    },
  };
}
