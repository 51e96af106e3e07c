// Opens a page in Chromium, waits, takes pictures: node browse.mjs PLAYWRIGHT CHROMIUM URL OUT.png SECONDS
import { createRequire } from "node:module";
const [library, executablePath, url, out, seconds] = process.argv.slice(2);
const { chromium } = createRequire(library + "/")("playwright-core");
const browser = await chromium.launch({
  executablePath,
  headless: true,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
         "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
try {
  const page = await browser.newPage({ viewport: { width: 1400, height: 800 } });
  const said = [];
  page.on("pageerror", (error) => said.push(String(error)));
  await page.goto(url, { waitUntil: "domcontentloaded" });
  await page.waitForTimeout(1000 * Number(seconds));
  await page.screenshot({ path: out, timeout: 120000 });
  console.log(JSON.stringify({ title: await page.title(), errors: said }));
} finally {
  await browser.close();
}
