// The page of the parameter tool in Firefox, by WebDriver BiDi: does what a user does, and prints what there is to see as JSON.
//
//     node page.mjs FIREFOX PAGE SOURCE...

import { readFileSync } from "node:fs";
import { basename } from "node:path";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const [firefox, file, ...sources] = process.argv.slice(2);
const browser = await puppeteer.launch({ browser: "firefox", executablePath: firefox, headless: true });
const complaints = [];
try {
  const page = await browser.newPage();
  await page.setViewport({ width: 1366, height: 768 });
  page.on("console", (message) => complaints.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => complaints.push(String(error)));
  await page.goto(pathToFileURL(file).href);

  // The first page, and an example of it.
  await page.waitForFunction(() => document.querySelectorAll(".card .spark svg").length > 10);
  const cards = await page.$$eval(".card", (all) => all.length);
  await page.click(".card:not(#program-card)");
  await page.waitForFunction(() => /[1-9]\d* cycles/.test(document.querySelector("#run .status")?.textContent ?? ""));
  const example = await page.evaluate(async () => {
    const { store } = await globalThis.moduleOf("tool/store.js");
    const { ask } = await globalThis.moduleOf("tool/engine.js");
    const { events, calls, setup } = await ask({ do: "events" });
    const view = await ask({ do: "view", variables: Object.keys(store.state.values).sort(), points: calls });
    return { setup, events, calls, view };
  });
  const ink = await page.evaluate(() => {
    const canvas = document.querySelector("#curves canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.reduce((count, value, at) => count + (at % 4 === 3 && value > 0 ? 1 : 0), 0);
  });

  // A step test, a rule, its settings into the block.
  await page.click('#tab-tune');
  await page.click("#step-test");
  await page.waitForFunction(() => document.querySelectorAll("#tune .rules tbody tr").length > 5);
  const fit = await page.$eval("#tune .fit", (one) => one.textContent);
  await page.waitForFunction(() => document.querySelectorAll(".bode canvas").length === 2);
  const margins = await page.$$eval(".bode tbody tr", (rows) => rows.map((row) => row.innerText.split("\t")));
  await page.evaluate(() => [...document.querySelectorAll("#tune button")].find((one) => one.textContent === "Apply").click());
  await page.keyboard.down("Control");
  await page.keyboard.press("Enter");
  await page.keyboard.up("Control");
  const settings = () =>
    page.evaluate(async () => {
      const { store } = await globalThis.moduleOf("tool/store.js");
      return { gain: store.loop.settings.GAIN.sent, calls: store.state.calls, edited: store.edited() };
    });
  await page.waitForFunction(async () => (await globalThis.moduleOf("tool/store.js")).store.edited().length === 0);
  const before = await settings();

  // What a reload keeps.
  await new Promise((done) => setTimeout(done, 500));
  await page.reload();
  await page.waitForFunction(
    (calls) => document.querySelector("#run .status")?.textContent.includes(` ${calls} cycles`),
    {},
    before.calls,
  );
  const after = await settings();

  // A block in LAD, which is dropped: a start that is held, and what a name says.
  await page.evaluate(
    (files) => {
      const dataTransfer = new DataTransfer();
      for (const [name, text] of files) dataTransfer.items.add(new File([text], name));
      document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
    },
    sources.map((path) => [basename(path), readFileSync(path, "utf8")]),
  );
  await page.waitForSelector(".network");
  const cycle = async () => {
    const status = await page.$eval("#run .status", (one) => one.textContent);
    await page.evaluate(() => [...document.querySelectorAll("#run button")].find((one) => one.textContent === "One cycle").click());
    await page.waitForFunction((before) => document.querySelector("#run .status").textContent !== before, {}, status);
  };
  await page.click('[data-input="raw"] input.number', { count: 3 });
  await page.keyboard.type("13824");
  await page.keyboard.press("Enter");
  await page.click('[data-input="start"] [aria-label="Make start a toggle switch"]');
  await page.click('[data-input="start"] [role=switch]');
  await cycle();
  await page.click('[data-input="start"] [role=switch]');
  await cycle();
  // The start is open, and the coil holds itself.
  await page.waitForFunction(() => document.querySelectorAll('[data-network="4"] path.wire.is-off').length === 2);
  const ladder = await page.evaluate(() => {
    const label = [...document.querySelectorAll('[data-network="4"] .operand')].find((one) => one.firstChild.textContent === "#run");
    label.dispatchEvent(new MouseEvent("click", { bubbles: true }));
    const bar = document.querySelector(".ladder-bar");
    [...bar.querySelectorAll("button")].find((one) => one.textContent === "Why").click();
    return { titles: [...document.querySelectorAll(".network h3")].map((one) => one.textContent), bar: bar.innerText };
  });
  await page.waitForSelector(".why:not([hidden])");
  ladder.why = await page.$eval(".why .why-statement", (one) => one.innerText);
  ladder.conducts = await page.$$eval('[data-network="4"] path.wire.is-on', (all) => all.length);
  await page.setViewport({ width: 390, height: 844 });
  ladder.sideways = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  console.log(JSON.stringify({ cards, example, ink, fit, margins, before, after, ladder, complaints }));
} finally {
  await browser.close();
}
