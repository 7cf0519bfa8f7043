/* The one function of this Windows DLL that Rust's standard library calls, for a Wine that does not have the DLL (8.0):
 *
 *   x86_64-w64-mingw32-gcc -O1 -shared -o bcryptprimitives.dll bcryptprimitives.c -ladvapi32
 */
#include <windows.h>
#include <ntsecapi.h>

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE bytes, SIZE_T length) {
    return RtlGenRandom(bytes, (ULONG)length);
}
