// Builds the examples that need a bundler: npm run build, then serve dist/ with a baked file courtyard-baked.glb beside each page.
import { svelte } from '@sveltejs/vite-plugin-svelte';
import { templateCompilerOptions } from '@tresjs/core';
import react from '@vitejs/plugin-react';
import vue from '@vitejs/plugin-vue';
import { defineConfig } from 'vite';

export default defineConfig({
    base: './',
    plugins: [react(), svelte(), vue(templateCompilerOptions)],
    resolve: { preserveSymlinks: true },
    build: { rolldownOptions: { input: ['react/index.html', 'threlte/index.html', 'tres/index.html'] } },
});
