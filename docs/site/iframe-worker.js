// The search runs in a worker, which a page opened from disk may not start. On such a page, this class replaces Worker and runs
// the script in a hidden frame of the same origin. The theme loads this file by its name.
"use strict";

class FrameWorker extends EventTarget {
    constructor(address) {
        super();
        this.frame = document.createElement("iframe");
        this.frame.hidden = true;
        document.body.append(this.frame);
        this.scope = this.frame.contentWindow;
        this.scope.postMessage = (data) => this.receive(data);
        this.scope.importScripts = async (...addresses) => {
            for (const one of addresses) await this.load(one);
        };
        this.loaded = this.load(address);
    }

    /** Runs a script in the frame. */
    load(address) {
        return new Promise((resolve, reject) => {
            const script = this.scope.document.createElement("script");
            script.onload = resolve;
            script.onerror = () => reject(new Error(`${address} cannot be loaded`));
            script.src = new URL(address, document.baseURI);
            this.scope.document.body.append(script);
        });
    }

    /** Passes a message from the script to the page. */
    receive(data) {
        const event = new MessageEvent("message", {data});
        this.dispatchEvent(event);
        this.onmessage?.(event);
    }

    /** Passes a message from the page to the script, once it has loaded. */
    async postMessage(data) {
        await this.loaded;
        this.scope.dispatchEvent(new this.scope.MessageEvent("message", {data: structuredClone(data)}));
    }

    terminate() {
        this.frame.remove();
    }
}

if (location.protocol === "file:") window.Worker = FrameWorker;
