// What a JSON Schema lets stand at a place of a text, with its help in words.

const DEEPEST = 12;

// The schema with all that it refers to, as a list of alternatives that refer to nothing.
function plain(root, schema, depth = 0) {
  if (!schema || typeof schema !== "object" || depth > DEEPEST) return [];
  const { $ref: reference, anyOf, oneOf, allOf, ...own } = schema;
  const parts = [...(anyOf ?? []), ...(oneOf ?? []), ...(allOf ?? [])];
  const named = reference ? [root.$defs?.[reference.replace("#/$defs/", "")]] : [];
  const found = [...named, ...parts].flatMap((each) => plain(root, each, depth + 1));
  const described = found.map((each) => (own.description ? { ...each, description: own.description } : each));
  const says = Object.keys(own).some((key) => key !== "description");
  return says || !described.length ? [own, ...described] : described;
}

function inside(root, schema, step) {
  if (typeof step === "number") return plain(root, schema.prefixItems?.[step] ?? schema.items);
  const known = schema.properties?.[step];
  if (known) return plain(root, known);
  const fitting = Object.entries(schema.patternProperties ?? {}).find(([pattern]) => new RegExp(pattern, "u").test(step));
  return plain(root, fitting ? fitting[1] : schema.additionalProperties);
}

export function schemasAt(root, path) {
  return path.reduce((found, step) => found.flatMap((each) => inside(root, each, step)), plain(root, root));
}

function keysOf(root, schemas) {
  return schemas.flatMap((schema) =>
    Object.entries(schema.properties ?? {}).map(([key, spec]) => {
      const there = plain(root, spec);
      const needed = [...new Set(there.flatMap((each) => (each.properties && each.required) || []))];
      const isMapping = there.some((each) => each.properties) && !there.some((each) => each.enum);
      const description = spec.description ?? there.find((each) => each.description)?.description ?? "";
      return { label: key, description, needed, isMapping, required: (schema.required ?? []).includes(key), kind: "key" };
    }));
}

function valuesOf(schemas) {
  return schemas.flatMap((schema) => {
    const described = schema.enumDescriptions ?? schema.markdownEnumDescriptions ?? [];
    const named = (schema.enum ?? ("const" in schema ? [schema.const] : [])).map((each, i) => ({ label: String(each), description: described[i] ?? schema.description ?? "" }));
    const either = [schema.type].flat().includes("boolean") ? ["true", "false"].map((label) => ({ label, description: "" })) : [];
    return [...named, ...either].map((each) => ({ ...each, kind: "value" }));
  });
}

function unique(options) {
  return [...new Map(options.map((each) => [`${each.kind} ${each.label}`, each])).values()];
}

// What may stand at a place: keys of a mapping, values, and the items of a list that is begun.
export function offered(root, place, present = []) {
  const here = schemasAt(root, place.path);
  if (place.kind === "value") return unique([...valuesOf(here), ...keysOf(root, here).map((each) => ({ ...each, inline: true }))]);
  const items = here.filter((each) => each.items).flatMap((each) => plain(root, each.items));
  const own = keysOf(root, here).filter((each) => !present.includes(each.label));
  const listed = [...keysOf(root, items), ...valuesOf(items)].map((each) => ({ ...each, item: true }));
  return unique([...own, ...valuesOf(here), ...listed]);
}

// The help for a key of a mapping, or for a value that stands at a place.
export function explained(root, { path, kind }, word) {
  const here = schemasAt(root, path);
  if (kind === "key") {
    const key = keysOf(root, here).find((each) => each.label === word);
    const either = key ?? valuesOf(here).find((each) => each.label === word);
    return either ? either.description : "";
  }
  const value = valuesOf(here).find((each) => each.label === word);
  return value?.description || here.find((each) => each.description)?.description || "";
}
