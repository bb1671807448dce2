// What the page takes of three.js; three.min.js is made of it by
//   npm install three@0.187.0 esbuild@0.28.2
//   npx esbuild three.js --bundle --minify --format=iife --global-name=THREE --outfile=three.min.js
export {
  BufferAttribute, BufferGeometry, Color, DoubleSide, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial,
  PerspectiveCamera, Points, PointsMaterial, Scene, Vector3, WebGLRenderer,
} from 'three';
export { OrbitControls } from 'three/addons/controls/OrbitControls.js';
