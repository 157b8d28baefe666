// Meshes of the page as geometries: surfaces as src/program/surface.c packs them, and Collada.
// SPDX-License-Identifier: BSD-3-Clause
import { BufferAttribute, BufferGeometry, SRGBColorSpace } from "three";
import { ColladaLoader } from "three/addons/loaders/ColladaLoader.js";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { bytesOf } from "./data.js";
import { unpack, withNormals } from "./surface.js";

function geometryOf({ position, normal, index }) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(position, 3));
    geometry.setAttribute("normal", new BufferAttribute(normal, 3));
    geometry.setIndex(new BufferAttribute(index, 1));
    return geometry;
}

// ---- Collada ----

// Position and normal of the triangles from `start` on, of a mesh whose place in the file is `map`.
function cut(geometry, map, { start, count }) {
    const part = new BufferGeometry();
    for (const name of ["position", "normal"]) {
        const { array } = geometry.attributes[name];
        part.setAttribute(name, new BufferAttribute(Float32Array.from(array.subarray(3 * start, 3 * (start + count))), 3));
    }
    return part.applyMatrix4(map);
}

// What could not be seen at all is opaque: programs take <transparency> for its opposite.
const opacityOf = (material) => material.opacity || 1;

function colourOf(material) {
    const { r, g, b } = material.color.getRGB({ r: 0, g: 0, b: 0 }, SRGBColorSpace);
    return [r, g, b];
}

// In metres, the axes as they stand in the file: URDF pays no heed to <up_axis>. Pictures are left out.
function readCollada(text) {
    const { scene } = new ColladaLoader().parse(text.replace(/<library_images[\s\S]*?<\/library_images>/, ""), "");
    const paints = new Map();
    scene.rotation.set(0, 0, 0);
    scene.updateMatrixWorld(true);
    scene.traverse((node) => {
        if (!node.isMesh || !node.geometry.attributes.position) return;
        const { geometry } = node, materials = [node.material].flat();
        if (!geometry.attributes.normal) geometry.computeVertexNormals();
        const all = [{ start: 0, count: geometry.attributes.position.count, materialIndex: 0 }];
        for (const group of geometry.groups.length > 0 ? geometry.groups : all) {
            const material = materials[group.materialIndex] ?? materials[0], colour = colourOf(material),
                key = `${colour} ${opacityOf(material)}`;
            if (!paints.has(key)) paints.set(key, { colour, opacity: opacityOf(material), parts: [] });
            paints.get(key).parts.push(cut(geometry, node.matrixWorld, group));
        }
    });
    return [...paints.values()].map(({ parts, ...paint }) => ({ ...paint, geometry: mergeGeometries(parts) }));
}

// Parts of a mesh, each { geometry, colour, opacity }; without a colour where the file has none. Empty: there is nothing
// to draw.
export async function readMesh(mesh) {
    if (mesh.surface) return [{ geometry: geometryOf(withNormals(unpack(await bytesOf(mesh.surface), mesh))) }];
    if (mesh.collada) return readCollada(new TextDecoder().decode(await bytesOf(mesh.collada)));
    return [];
}

// The same seen in a mirror: its triangles turn the other way round.
export function mirrored(geometry) {
    const other = geometry.clone(), count = geometry.attributes.position.count;
    const index = geometry.index ? geometry.index.array.slice() : Uint32Array.from({ length: count }, (_, k) => k);
    for (let k = 0; k + 2 < index.length; k += 3) [index[k + 1], index[k + 2]] = [index[k + 2], index[k + 1]];
    other.setIndex(new BufferAttribute(index, 1));
    return other;
}
