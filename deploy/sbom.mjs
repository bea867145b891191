// The image's bill of materials, SPDX 2.3 as JSON: node deploy/sbom.mjs PACKAGES.tsv > sbom.spdx.json
// PACKAGES.tsv is what dpkg-query says of the image: package, version, architecture, source package, source version. The page's
// libraries are those of package-lock.json that are no tools of the tests or of the build, of which esbuild is one, with the checksums that `npm ci` holds them against.
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
const read = (/** @type {string} */ name) => readFileSync(path.join(ROOT, name), 'utf8');
const hex = (/** @type {string} */ text) => createHash('sha256').update(text).digest('hex');
const id = (/** @type {string[]} */ ...parts) => `SPDXRef-${parts.join('-').replace(/[^A-Za-z0-9.-]/g, '-')}`;
const purl = (/** @type {string} */ locator) => [
  { referenceCategory: 'PACKAGE-MANAGER', referenceType: 'purl', referenceLocator: locator },
];
const unknown = { filesAnalyzed: false, licenseConcluded: 'NOASSERTION', copyrightText: 'NOASSERTION' };

/** @param {string} tsv of dpkg-query @param {any} lock package-lock.json @param {string} created ISO 8601 */
export function sbom(tsv, lock, created) {
  const own = {
    SPDXID: id('laglab'),
    name: 'laglab',
    versionInfo: lock.version,
    downloadLocation: 'NOASSERTION',
    ...unknown,
    licenseDeclared: 'MIT',
    primaryPackagePurpose: 'APPLICATION',
  };
  const debian = tsv
    .split('\n')
    .filter(Boolean)
    .map((line) => {
      const [name, version, architecture, source, source_version] = line.split('\t'),
        bare = name.replace(/:.*/, '');
      const more = source && source !== bare ? `&upstream=${encodeURIComponent(`${source}@${source_version}`)}` : '';
      return {
        SPDXID: id('deb', bare, architecture),
        name: bare,
        versionInfo: version,
        supplier: 'Organization: Debian',
        downloadLocation: 'NOASSERTION',
        ...unknown,
        licenseDeclared: 'NOASSERTION',
        sourceInfo: `built from ${source || bare} ${source_version || version}`,
        externalRefs: purl(
          `pkg:deb/debian/${encodeURIComponent(bare)}@${encodeURIComponent(version)}?arch=${architecture}&distro=debian-12${more}`,
        ),
      };
    });
  const npm = Object.entries(lock.packages)
    .filter(([place, one]) => !['', 'node_modules/esbuild'].includes(place) && !(one.dev || one.optional || one.devOptional))
    .map(([place, one]) => {
      const name = place.replace(/^.*node_modules\//, ''),
        [algorithm, sum] = one.integrity.split(/-(.*)/s);
      return {
        SPDXID: id('npm', name),
        name,
        versionInfo: one.version,
        downloadLocation: one.resolved ?? 'NOASSERTION', // the package's URL below names it
        ...unknown,
        licenseDeclared: one.license ?? 'NOASSERTION',
        checksums: [{ algorithm: algorithm.toUpperCase(), checksumValue: Buffer.from(sum, 'base64').toString('hex') }],
        externalRefs: purl(`pkg:npm/${name.replace('@', '%40')}@${one.version}`),
      };
    });
  const parts = [...debian, ...npm];
  return {
    spdxVersion: 'SPDX-2.3',
    dataLicense: 'CC0-1.0',
    SPDXID: 'SPDXRef-DOCUMENT',
    name: `laglab-${lock.version}-image`,
    documentNamespace: `https://spdx.org/spdxdocs/laglab-${lock.version}-${hex(tsv + JSON.stringify(lock)).slice(0, 32)}`,
    creationInfo: { created, creators: ['Tool: laglab-deploy/sbom.mjs'] },
    packages: [own, ...parts],
    relationships: [
      { spdxElementId: 'SPDXRef-DOCUMENT', relationshipType: 'DESCRIBES', relatedSpdxElement: own.SPDXID },
      ...parts.map((part) => ({ spdxElementId: own.SPDXID, relationshipType: 'DEPENDS_ON', relatedSpdxElement: part.SPDXID })),
    ],
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [, , packages = ''] = process.argv,
    epoch = process.env.SOURCE_DATE_EPOCH,
    now = epoch ? new Date(1000 * Number(epoch)) : new Date();
  console.log(
    JSON.stringify(
      sbom(readFileSync(packages, 'utf8'), JSON.parse(read('package-lock.json')), now.toISOString().replace(/\.\d+Z$/, 'Z')),
      null,
      1,
    ),
  );
}
