! The half rod of derod.branches as AUTO-07p wants it: 17 unknowns on [0, 1], its Jacobian written out.
!
!   u(1:3) w, u(4:7) q, u(8:10) n in the drop;  u(11:13) w, u(14:17) q outside, where n is constant
!   par: c_x, c_z, u3, sigma, delta, n_x, T;  v0, rho, k3, l, f_gamma
!
!   w' = d3(q),  q' = (m q + (1 - k3) u3 q e3)/2,  m = c - w x n,  n' = grad v   (derod/branches/half_rod/element.py)

module half_rod
  implicit none
  integer, parameter :: dp = kind(1d0)
contains
  ! The rates of w and q, and with jac their derivatives: f (7), by (w, q, n) in j (7,10), by (cx, cz, u3) in p.
  subroutine rates(w, q, n, cx, cz, u3, k3, jac, f, j, p)
    real(dp), intent(in) :: w(3), q(4), n(3), cx, cz, u3, k3
    logical, intent(in) :: jac
    real(dp), intent(out) :: f(7), j(7,10), p(7,3)
    real(dp) :: m(3), a, l(4,3), mw(3,3), mn(3,3)
    m = (/ cx - (w(2)*n(3) - w(3)*n(2)), -(w(3)*n(1) - w(1)*n(3)), cz - (w(1)*n(2) - w(2)*n(1)) /)
    a = (1 - k3)*u3
    f(1) = 2*(q(2)*q(4) + q(1)*q(3))
    f(2) = 2*(q(3)*q(4) - q(1)*q(2))
    f(3) = q(1)**2 - q(2)**2 - q(3)**2 + q(4)**2
    l(1,:) = 0.5d0*(/ -q(2), -q(3), -q(4) /)
    l(2,:) = 0.5d0*(/ q(1), q(4), -q(3) /)
    l(3,:) = 0.5d0*(/ -q(4), q(1), q(2) /)
    l(4,:) = 0.5d0*(/ q(3), -q(2), q(1) /)
    f(4:7) = matmul(l, m) + 0.5d0*a*(/ -q(4), q(3), -q(2), q(1) /)
    if (.not. jac) return
    j = 0
    j(1,4:7) = 2*(/ q(3), q(4), q(1), q(2) /)
    j(2,4:7) = 2*(/ -q(2), -q(1), q(4), q(3) /)
    j(3,4:7) = 2*(/ q(1), -q(2), -q(3), q(4) /)
    mw(1,:) = (/ 0d0, -n(3), n(2) /)
    mw(2,:) = (/ n(3), 0d0, -n(1) /)
    mw(3,:) = (/ -n(2), n(1), 0d0 /)
    mn(1,:) = (/ 0d0, w(3), -w(2) /)
    mn(2,:) = (/ -w(3), 0d0, w(1) /)
    mn(3,:) = (/ w(2), -w(1), 0d0 /)
    j(4:7,1:3) = matmul(l, mw)
    j(4:7,8:10) = matmul(l, mn)
    j(4,4:7) = 0.5d0*(/ 0d0, -m(1), -m(2), -m(3) - a /)
    j(5,4:7) = 0.5d0*(/ m(1), 0d0, -m(3) + a, m(2) /)
    j(6,4:7) = 0.5d0*(/ m(2), m(3) - a, 0d0, -m(1) /)
    j(7,4:7) = 0.5d0*(/ m(3) + a, -m(2), m(1), 0d0 /)
    p(:,1:3) = 0
    p(4:7,1) = l(:,1)
    p(4:7,2) = l(:,3)
    p(4:7,3) = 0.5d0*(1 - k3)*(/ -q(4), q(3), -q(2), q(1) /)
  end subroutine

  ! The 23 end conditions (derod/branches/half_rod/closure.py), complex for exact derivatives.
  subroutine ends(par, a, b, f)
    complex(dp), intent(in) :: par(12), a(17), b(17)
    complex(dp), intent(out) :: f(23)
    complex(dp) :: t(3), m(3), s
    f(1:5) = (/ a(1), a(3), a(5), a(7), a(9) /)
    f(6) = a(4)**2 + a(5)**2 + a(6)**2 + a(7)**2 - 1
    t = tangent(a(4:7))
    m(1) = par(1) - (a(2)*a(10) - a(3)*a(9))
    m(2) = -(a(3)*a(8) - a(1)*a(10))
    m(3) = par(2) - (a(1)*a(9) - a(2)*a(8))
    f(7) = sum(m*t) - par(10)*par(3)
    f(8) = sum(b(1:3)**2) - 0.25d0
    f(9:15) = b(1:7) - a(11:17)
    s = (par(12) - par(8)/par(9))/sum(b(1:3)*tangent(b(4:7)))
    f(16:18) = b(8:10) + s*b(1:3) - (/ par(6), (0d0, 0d0), par(7) /)
    f(19) = b(11)
    f(20) = b(13) - 0.5d0*par(11) + 0.5d0*par(5)
    f(21:23) = b(15:17)
  end subroutine

  function tangent(q) result(t)
    complex(dp), intent(in) :: q(4)
    complex(dp) :: t(3)
    t = (/ 2*(q(2)*q(4) + q(1)*q(3)), 2*(q(3)*q(4) - q(1)*q(2)), q(1)**2 - q(2)**2 - q(3)**2 + q(4)**2 /)
  end function
end module

subroutine func(ndim, u, icp, par, ijac, f, dfdu, dfdp)
  use half_rod
  implicit none
  integer, intent(in) :: ndim, icp(*), ijac
  double precision, intent(in) :: u(ndim), par(*)
  double precision, intent(out) :: f(ndim)
  double precision, intent(inout) :: dfdu(ndim, *), dfdp(ndim, *)
  double precision :: n(3), g(7), j(7,10), p(7,3), r, gap, slope, across, along, sigma, outer
  integer :: i, k
  logical :: jac
  jac = ijac > 0
  sigma = par(4)
  outer = 0.5d0*par(11) - sigma
  if (jac) dfdu(:, 1:ndim) = 0
  if (ijac == 2) dfdp(:, 1:7) = 0
  call rates(u(1:3), u(4:7), u(8:10), par(1), par(2), par(3), par(10), jac, g, j, p)
  f(1:7) = sigma*g
  r = max(sqrt(sum(u(1:3)**2)), 1d-200)
  gap = 1 + par(9) - 2*r
  slope = 2*par(8)/gap**2
  across = slope/r
  f(8:10) = sigma*across*u(1:3)
  if (jac) then
    dfdu(1:7, 1:10) = sigma*j
    along = 4*slope/gap - across
    do i = 1, 3
      do k = 1, 3
        dfdu(7 + i, k) = sigma*along*u(i)/r*u(k)/r
      end do
      dfdu(7 + i, i) = dfdu(7 + i, i) + sigma*across
    end do
  end if
  if (ijac == 2) then
    dfdp(1:7, 1:3) = sigma*p
    dfdp(1:7, 4) = g
    dfdp(8:10, 4) = across*u(1:3)
  end if
  n = (/ par(6), 0d0, par(7) /)
  call rates(u(11:13), u(14:17), n, par(1), par(2), par(3), par(10), jac, g, j, p)
  f(11:17) = outer*g
  if (jac) dfdu(11:17, 11:17) = outer*j(:, 1:7)
  if (ijac == 2) then
    dfdp(11:17, 1:3) = outer*p
    dfdp(11:17, 4) = -g
    dfdp(11:17, 6) = outer*j(:, 8)
    dfdp(11:17, 7) = outer*j(:, 10)
  end if
end subroutine

subroutine bcnd(ndim, par, icp, nbc, u0, u1, fb, ijac, dbc)
  use half_rod
  implicit none
  integer, intent(in) :: ndim, icp(*), nbc, ijac
  double precision, intent(in) :: par(*), u0(ndim), u1(ndim)
  double precision, intent(out) :: fb(nbc)
  double precision, intent(inout) :: dbc(nbc, *)
  complex(dp) :: p(12), a(17), b(17), f(23)
  double precision, parameter :: h = 1d-30
  integer :: k
  p = par(1:12)
  a = u0
  b = u1
  call ends(p, a, b, f)
  fb = real(f)
  if (ijac == 0) return
  do k = 1, ndim
    a(k) = cmplx(u0(k), h, dp)
    call ends(p, a, b, f)
    dbc(:, k) = aimag(f)/h
    a(k) = u0(k)
    b(k) = cmplx(u1(k), h, dp)
    call ends(p, a, b, f)
    dbc(:, ndim + k) = aimag(f)/h
    b(k) = u1(k)
  end do
  if (ijac == 1) return
  do k = 1, 7
    p(k) = cmplx(par(k), h, dp)
    call ends(p, a, b, f)
    dbc(:, 2*ndim + k) = aimag(f)/h
    p(k) = par(k)
  end do
end subroutine

subroutine stpnt(ndim, u, par, t)
  implicit none
  integer, intent(in) :: ndim
  double precision, intent(inout) :: u(ndim), par(*)
  double precision, intent(in) :: t
  ! a first buckled state of the rod: rows t, u; before them the parameters
  integer, save :: rows = 0
  double precision, save :: table(18, 4000), first(12)
  double precision :: x
  integer :: i
  if (rows == 0) then
    open(unit=77, file='start.txt', status='old')
    read(77, *) first
    read(77, *) rows
    do i = 1, rows
      read(77, *) table(:, i)
    end do
    close(77)
  end if
  par(1:12) = first
  i = 1
  do while (i < rows - 1 .and. table(1, i + 1) < t)
    i = i + 1
  end do
  x = (t - table(1, i))/(table(1, i + 1) - table(1, i))
  u = table(2:18, i) + x*(table(2:18, i + 1) - table(2:18, i))
end subroutine

subroutine icnd
end subroutine

subroutine fopt
end subroutine

subroutine pvls
end subroutine
