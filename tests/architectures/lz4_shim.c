/* lz4-sys 1.11 calls these functions on wasm32, and defines them only where there is no WASI. */
#include <stdlib.h>
#include <string.h>

void *rust_lz4_wasm_shim_malloc(size_t size) { return malloc(size); }
void *rust_lz4_wasm_shim_calloc(size_t count, size_t size) { return calloc(count, size); }
void rust_lz4_wasm_shim_free(void *block) { free(block); }
void *rust_lz4_wasm_shim_memcpy(void *to, const void *from, size_t size) { return memcpy(to, from, size); }
void *rust_lz4_wasm_shim_memmove(void *to, const void *from, size_t size) { return memmove(to, from, size); }
void *rust_lz4_wasm_shim_memset(void *to, int byte, size_t size) { return memset(to, byte, size); }
int rust_lz4_wasm_shim_memcmp(const void *one, const void *other, size_t size) { return memcmp(one, other, size); }
