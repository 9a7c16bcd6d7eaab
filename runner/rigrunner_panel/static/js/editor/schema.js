// What a JSON Schema lets stand at a place of a text, with its help in words.

const DEEPEST = 12;

// The schema with all that it refers to, as a list of alternatives that refer to nothing.
function plain(root, schema, depth = 0) {
  if (!schema || typeof schema !== "object" || depth > DEEPEST) return [];
  const { $ref: reference, anyOf, oneOf, allOf, ...direct } = schema;
  const parts = [...(anyOf ?? []), ...(oneOf ?? []), ...(allOf ?? [])];
  const referenced = reference ? [root.$defs?.[reference.replace("#/$defs/", "")]] : [];
  const alternatives = [...referenced, ...parts].flatMap((part) => plain(root, part, depth + 1));
  const described = alternatives.map((alternative) => (direct.description ? { ...alternative, description: direct.description } : alternative));
  const hasContent = Object.keys(direct).some((key) => key !== "description");
  return hasContent || !described.length ? [direct, ...described] : described;
}

function inside(root, schema, step) {
  if (typeof step === "number") return plain(root, schema.prefixItems?.[step] ?? schema.items);
  const property = schema.properties?.[step];
  if (property) return plain(root, property);
  const match = Object.entries(schema.patternProperties ?? {}).find(([pattern]) => new RegExp(pattern, "u").test(step));
  return plain(root, match ? match[1] : schema.additionalProperties);
}

export function schemasAt(root, path) {
  return path.reduce((schemas, step) => schemas.flatMap((schema) => inside(root, schema, step)), plain(root, root));
}

function keysOf(root, schemas) {
  return schemas.flatMap((schema) =>
    Object.entries(schema.properties ?? {}).map(([key, spec]) => {
      const options = plain(root, spec);
      const needed = [...new Set(options.flatMap((option) => (option.properties && option.required) || []))];
      const isMapping = options.some((option) => option.properties) && !options.some((option) => option.enum);
      const description = spec.description ?? options.find((option) => option.description)?.description ?? "";
      return { label: key, description, needed, isMapping, required: (schema.required ?? []).includes(key), kind: "key" };
    }));
}

function valuesOf(schemas) {
  return schemas.flatMap((schema) => {
    const described = schema.enumDescriptions ?? schema.markdownEnumDescriptions ?? [];
    const listed = (schema.enum ?? ("const" in schema ? [schema.const] : [])).map((value, i) => ({ label: String(value), description: described[i] ?? schema.description ?? "" }));
    const booleans = [schema.type].flat().includes("boolean") ? ["true", "false"].map((label) => ({ label, description: "" })) : [];
    return [...listed, ...booleans].map((option) => ({ ...option, kind: "value" }));
  });
}

function unique(options) {
  return [...new Map(options.map((option) => [`${option.kind} ${option.label}`, option])).values()];
}

// What may stand at a place: keys of a mapping, values, and the items of a list that is begun.
export function offered(root, place, present = []) {
  const schemas = schemasAt(root, place.path);
  if (place.kind === "value") return unique([...valuesOf(schemas), ...keysOf(root, schemas).map((key) => ({ ...key, inline: true }))]);
  const items = schemas.filter((schema) => schema.items).flatMap((schema) => plain(root, schema.items));
  const keys = keysOf(root, schemas).filter((key) => !present.includes(key.label));
  const itemOptions = [...keysOf(root, items), ...valuesOf(items)].map((option) => ({ ...option, item: true }));
  return unique([...keys, ...valuesOf(schemas), ...itemOptions]);
}

// The help for a key of a mapping, or for a value that stands at a place.
export function explained(root, { path, kind }, word) {
  const schemas = schemasAt(root, path);
  if (kind === "key") {
    const key = keysOf(root, schemas).find((option) => option.label === word);
    const match = key ?? valuesOf(schemas).find((option) => option.label === word);
    return match ? match.description : "";
  }
  const value = valuesOf(schemas).find((option) => option.label === word);
  return value?.description || schemas.find((schema) => schema.description)?.description || "";
}
