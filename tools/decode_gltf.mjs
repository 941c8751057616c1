// Prints, for each compressed GLB named, one JSON line: per triangle primitive the bytes of its indices (as 32 bit) and
// attributes, in base64, as meshoptimizer and Draco decode them. Run with a folder of node modules as the current one:
// node --input-type=module - FILE... < decode_gltf.mjs
import { readFile } from "node:fs/promises";
import { NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import draco3d from "draco3dgltf";
import { MeshoptDecoder } from "meshoptimizer";

await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  "draco3d.decoder": await draco3d.createDecoderModule(),
  "meshopt.decoder": MeshoptDecoder,
});
const base64 = (array) => Buffer.from(array.buffer, array.byteOffset, array.byteLength).toString("base64");
for (const file of process.argv.slice(2)) {
  const parts = await io.binaryToJSON(new Uint8Array(await readFile(file)));
  // glTF-Transform knows the older name only; the streams and their decoder are the same.
  const text = JSON.stringify(parts.json).replaceAll("KHR_meshopt_compression", "EXT_meshopt_compression");
  const document = await io.readJSON({ ...parts, json: JSON.parse(text) });
  const primitives = document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives());
  const found = primitives.map((item) => ({
    indices: base64(Uint32Array.from(item.getIndices().getArray())),
    attributes: Object.fromEntries(
      item.listSemantics().map((name) => [name, base64(item.getAttribute(name).getArray())]),
    ),
  }));
  console.log(JSON.stringify(found));
}
