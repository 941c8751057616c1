// Images on the surface: where the corners of triangles lie on them, and the materials that show them.

import { DoubleSide, MeshStandardMaterial, RepeatWrapping, SRGBColorSpace, TextureLoader } from "three";
import { unpack } from "./decode.js";

/** {images, groups: [{start, count, image}], places: Float32Array (2 a corner)}; groups are runs of corners. */
export function decodeSkin(skin, triangles) {
  const faces = triangles.length / 3;
  const image = unpack(skin.image, faces, "images of triangles");
  const packed = unpack(skin.places, 2 * triangles.length, "places on images");
  const places = new Float32Array(packed.length);
  for (let i = 0; i < packed.length; i++) {
    const axis = i % 2;
    places[i] = skin.low[axis] + (packed[i] / 65535) * (skin.high[axis] - skin.low[axis]);
  }
  const groups = [];
  for (let face = 0; face < faces; face++) {
    const last = groups.at(-1);
    if (last && last.image === image[face]) last.count += 3;
    else groups.push({ start: 3 * face, count: 3, image: image[face] });
  }
  return { images: skin.images, groups, places };
}

/** Materials: the plain one, and one for each image; `loaded` is called as images arrive. */
export function skinMaterials(images, plain, loaded) {
  const loader = new TextureLoader();
  const dressed = images.map((source) => {
    const map = loader.load(source, loaded);
    map.colorSpace = SRGBColorSpace;
    map.wrapS = map.wrapT = RepeatWrapping;
    map.flipY = false;
    map.anisotropy = 4;
    return new MeshStandardMaterial({ map, vertexColors: true, roughness: plain.roughness, metalness: 0, side: DoubleSide });
  });
  return [plain, ...dressed];
}
