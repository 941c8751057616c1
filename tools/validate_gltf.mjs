// Prints, for each glTF or GLB file named, one JSON line: {"file": ..., "messages": [...]} from Khronos' validator.
import { readFile } from "node:fs/promises";
import { dirname, resolve } from "node:path";
import validator from "gltf-validator";

for (const file of process.argv.slice(2)) {
  const folder = dirname(file);
  const options = {
    uri: file,
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(resolve(folder, decodeURIComponent(uri)))),
  };
  try {
    const report = await validator.validateBytes(new Uint8Array(await readFile(file)), options);
    console.log(JSON.stringify({ file, messages: report.issues.messages }));
  } catch (error) {
    console.log(JSON.stringify({ file, messages: [{ code: "UNREADABLE", message: String(error), severity: 0 }] }));
  }
}
