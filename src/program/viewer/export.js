// Pictures and videos of what is shown.
// SPDX-License-Identifier: BSD-3-Clause
import {
    BufferTarget,
    CanvasSource,
    Output,
    QUALITY_HIGH,
    WebMOutputFormat,
    getFirstEncodableVideoCodec,
} from "mediabunny";

const rate = 30; // pictures a second

export function pictureOf(stage) {
    stage.draw();
    return new Promise((keep) => stage.renderer.domElement.toBlob(keep, "image/png"));
}

// A WebM of `seconds`, picture by picture however long each takes: show(k / n) draws what is seen then, progress(k / n)
// is told, and false from it ends the video there. Null: this browser makes no videos.
export async function videoOf(canvas, seconds, show, progress) {
    const size = { width: canvas.width, height: canvas.height };
    const codec = await getFirstEncodableVideoCodec(["vp9", "vp8"], size);
    if (!codec) return null;
    const output = new Output({ format: new WebMOutputFormat(), target: new BufferTarget() });
    const source = new CanvasSource(canvas, { codec, bitrate: QUALITY_HIGH });
    output.addVideoTrack(source, { frameRate: rate });
    await output.start();
    const count = Math.max(2, Math.round(rate * seconds));
    for (let k = 0; k < count && progress(k / count); ++k) {
        show(k / (count - 1));
        await source.add(k / rate, 1 / rate);
    }
    await output.finalize();
    return new Blob([output.target.buffer], { type: "video/webm" });
}
