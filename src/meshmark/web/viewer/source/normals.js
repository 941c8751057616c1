// Normals of the corners of triangles: smooth over gentle bends, sharp at creases.

const CREASE = 0.6; // cosine of the angle between two faces from which their common edge is shown as an edge

/** Unit normals (9m): each corner has the mean of those faces at its vertex that bend less than a crease from its own. */
export function cornerNormals(positions, triangles) {
  const faces = triangles.length / 3;
  const area = new Float32Array(3 * faces); // normal times twice the area of each face
  const unit = new Float32Array(3 * faces);
  for (let f = 0; f < faces; f++) {
    const [a, b, c] = [3 * triangles[3 * f], 3 * triangles[3 * f + 1], 3 * triangles[3 * f + 2]];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const length = Math.hypot(x, y, z) || 1;
    area.set([x, y, z], 3 * f);
    unit.set([x / length, y / length, z / length], 3 * f);
  }
  const { first, corners } = cornersOfVertices(triangles, positions.length / 3);
  const normals = new Float32Array(3 * triangles.length);
  for (let corner = 0; corner < triangles.length; corner++) {
    const own = 3 * Math.floor(corner / 3);
    let x = 0, y = 0, z = 0;
    for (let i = first[triangles[corner]]; i < first[triangles[corner] + 1]; i++) {
      const other = 3 * Math.floor(corners[i] / 3);
      const bend = unit[own] * unit[other] + unit[own + 1] * unit[other + 1] + unit[own + 2] * unit[other + 2];
      if (bend < CREASE) continue;
      x += area[other]; y += area[other + 1]; z += area[other + 2];
    }
    const length = Math.hypot(x, y, z);
    if (length > 0) normals.set([x / length, y / length, z / length], 3 * corner);
    else normals.set([unit[own], unit[own + 1], unit[own + 2]], 3 * corner);
  }
  return normals;
}

/** Which corners lie at each vertex: those of vertex v are corners[first[v]] to corners[first[v + 1] - 1]. */
function cornersOfVertices(triangles, vertices) {
  const first = new Uint32Array(vertices + 1);
  for (const vertex of triangles) first[vertex + 1]++;
  for (let v = 0; v < vertices; v++) first[v + 1] += first[v];
  const next = first.slice(0, vertices);
  const corners = new Uint32Array(triangles.length);
  triangles.forEach((vertex, corner) => { corners[next[vertex]++] = corner; });
  return { first, corners };
}
