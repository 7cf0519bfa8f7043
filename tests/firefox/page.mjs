// The page of the parameter tool in Firefox, by WebDriver BiDi: does what a user does, and prints what there is to see as JSON.
//
//     node page.mjs FIREFOX PAGE

import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const [firefox, file] = process.argv.slice(2);
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
  console.log(JSON.stringify({ cards, example, ink, fit, margins, before, after, complaints }));
} finally {
  await browser.close();
}
